"""Kept contours: what a person has kept stays among the contours, whatever filters or later runs leave of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.contours.result import Result
from cpm_core.contours.review import Mark, Neighborhood, Outline, attached
from cpm_core.numerics import polyline

_SAME = 2.0
"""Distance up to which two contours run along the same edge [px]."""

_MOST = 0.8
"""Share of a contour that has to run along another one to be it, or a part of it."""

_PLACES = 24
"""Number of places along a contour that are compared."""


def with_kept(result: Result, marks: Sequence[Mark]) -> Result:
    """The result with each kept contour that is not in it, or only in parts, as it was when it was kept.

    A contour is found again when one passes at its anchor and runs along most of it. Otherwise the kept one is added,
    last, and takes the place of the contours that run along it for most of their length.

    Parameters
    ----------
    result : Result
        Outcome of a run.
    marks : sequence of Mark
        Marks of contours of this image; only kept ones with an outline count.

    Returns
    -------
    Result
        The same one when all kept contours have been found again.
    """
    kept = [mark for mark in marks if mark.verdict == "kept" and mark.outline.points]
    if not kept:
        return result
    missing = _missing(result.contours, kept)
    if not missing:
        return result
    added = [mark.outline.contour(mark.name, mark.color) for mark in missing]
    rest = [contour for contour in result.contours if not any(_runs_along(contour, one) for one in added)]
    taken = {contour.number for contour in rest}
    for index, contour in enumerate(added):
        if contour.number in taken:  # a number of another session
            added[index] = replace(contour, number=0)
        taken.add(contour.number)
    return replace(result, contours=(*rest, *added))


def outline_of(contour: Contour) -> Outline:
    """Where a contour runs now, to restore it later."""
    points = tuple((round(row, 4), round(col, 4)) for row, col in contour.points.tolist())
    return Outline(points, contour.closed, contour.strength, contour.number)


def _missing(contours: Sequence[Contour], kept: Sequence[Mark]) -> list[Mark]:
    """The marks whose contour has not been found again as a whole."""
    if not contours:
        return list(kept)
    owner = attached(contours, [mark.anchor for mark in kept])
    places = [polyline.middles(mark.outline.contour().path, _PLACES) for mark in kept]
    place, contour, _ = Neighborhood(contours).pairs(np.concatenate(places), _SAME)
    found = []
    for index, mark in enumerate(kept):
        along = (contour == owner[index]) & (place // _PLACES == index) if owner[index] is not None else np.zeros(1)
        if along.sum() < _MOST * _PLACES:
            found.append(mark)
    return found


def _runs_along(contour: Contour, other: Contour) -> bool:
    low, high = other.box
    if (contour.box[0] > high + _SAME).any() or (contour.box[1] < low - _SAME).any():
        return False
    away = polyline.distances(other.path, polyline.middles(contour.path, _PLACES))
    return bool((away <= _SAME).mean() >= _MOST)
