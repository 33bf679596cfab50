"""Objects whose area is painted with a brush: pure edits of a document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from app.model.document.document import Document
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Position
from cpm_core.objects.segmented.segmented_object import Line, SegmentedObject
from cpm_core.objects.segmented.union import lies_on

_ON_BRUSH = 0.1
"""Difference between the distance from the path of the brush and its radius up to which a vertex is painted [px]."""


def brushed(
    document: Document,
    before: SegmentedObject | None,
    number: int,
    boundary: tuple[Line, ...],
    path: Sequence[Position],
    radius: float,
) -> Document:
    """The document in which an object has the boundary that a brush has given it.

    Parameters
    ----------
    document : Document
        What is edited.
    before : SegmentedObject or None
        The object as it was before the stroke of the brush; None for a new one.
    number : int
        The number of the object.
    boundary : tuple of tuple
        Closed curves (row, col) [px]; where there is none, the object is gone.
    path : sequence of (row, col)
        The way of the brush [px]. What its edge has made of the boundary follows no contour.
    radius : float
        Radius of the brush [px].

    Returns
    -------
    Document
        The object without clicks, of which the boundary is no longer the answer.
    """
    objects = document.objects
    items = {item.number: item for item in objects.items}
    if boundary:
        made = before or SegmentedObject(number, (), boundary, category=objects.category)
        kept = tuple(gap for gap in made.gaps if lies_on(gap, boundary))
        painted = tuple(line for curve in boundary for line in _painted(curve, path, radius))
        items[number] = replace(made, clicks=(), boundary=boundary, gaps=(*kept, *painted))
    else:
        items.pop(number, None)
    edited = objects.edited if objects.edited != number else 0
    clicks = objects.clicks if edited == objects.edited else ()
    return replace(document, objects=replace(objects, items=tuple(items.values()), edited=edited, clicks=clicks))


def _painted(curve: Line, path: Sequence[Position], radius: float) -> list[Line]:
    """The stretches of a closed curve that run along the edge of a brush."""
    points = np.array(curve)
    on = np.abs(polyline.distances(path, points) - radius) <= _ON_BRUSH
    if on.all():
        return [(*curve, curve[0])]
    first = int(np.argmin(on))  # off the brush, so that no stretch goes on from the end to the beginning
    points, on = np.roll(points, -first, axis=0), np.roll(on, -first)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], on, [False]]).astype(int)))
    stretches = (points[begin:end] for begin, end in ends.reshape(-1, 2))
    return [tuple((row, col) for row, col in line.tolist()) for line in stretches if len(line) > 1]
