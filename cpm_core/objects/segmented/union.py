"""The union of two objects, with a boundary that stays between the pixels, or a closed surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import skimage

from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array
from cpm_core.objects.segmented.bodies import surface_of_both
from cpm_core.objects.segmented.segmented_object import Line, SegmentedObject

_BLEND = 3.0
"""Range of distances that are blended [px]: a slit between objects up to half as wide is closed."""

_MARGIN, _BEYOND = 3, 5
"""Width around the boundaries in which distances are taken, and how far from the image a boundary is kept [px]."""

_NEAR = 1.0
"""Distance from the boundary up to which a gap still belongs to it [px]."""


def union(first: SegmentedObject, second: SegmentedObject, shape: tuple[int, ...]) -> SegmentedObject:
    """One object that covers two, as far as the image reaches, and a few pixels more.

    Its boundary is where the smaller of the signed distances from the two boundaries is zero. Where the boundaries face
    each other, the two distances are blended by the polynomial smooth minimum (I. Quilez, 2013), which closes the slit
    between objects that touch.

    Parameters
    ----------
    first, second : SegmentedObject
        The objects.
    shape : tuple of int
        Shape of their image or volume.

    Returns
    -------
    SegmentedObject
        The first one with the boundary of both, the clicks inside of both, the gaps that still belong to the boundary,
        and the means of confidence and strength weighted by perimeter.
    """
    if first.surface and second.surface:
        clicks = tuple(said for item in (first, second) for said in item.clicks if said.inside)
        return replace(first, clicks=clicks, surface=(surface_of_both(first.surface[0], second.surface[0]),))
    corners = np.concatenate([np.asarray(curve) for item in (first, second) for curve in item.boundary])
    # a boundary may lie beyond the image, but not so far that the memory is not enough
    low = np.clip(np.floor(corners.min(axis=0)), -_BEYOND, shape) - _MARGIN
    high = np.clip(np.ceil(corners.max(axis=0)), low, np.add(shape, _BEYOND)) + _MARGIN
    size = tuple((high - low + 1).astype(int).tolist())
    pixels = np.indices(size).reshape(2, -1).T + low
    one, other = (_signed(item, pixels).reshape(size) for item in (first, second))
    blend = np.maximum(_BLEND - np.abs(one - other), 0.0)
    facing = np.clip(-sum(a * b for a, b in zip(np.gradient(one), np.gradient(other), strict=True)), 0.0, 1.0)
    level = np.minimum(one, other) - facing * blend**2 / (4.0 * _BLEND)
    level[[0, -1]] = np.maximum(level[[0, -1]], 1.0)  # closed also where it is cut
    level[:, [0, -1]] = np.maximum(level[:, [0, -1]], 1.0)
    found = [line[:-1] + low for line in skimage.measure.find_contours(level, 0.0)]  # type: ignore[no-untyped-call]
    found = [line for line in found if polyline.area(line) >= 1.0]
    boundary = tuple(_line(line) for line in sorted(found, key=lambda line: -len(line)))
    lengths = [item.perimeter() for item in (first, second)]
    clicks = tuple(said for item in (first, second) for said in item.clicks if said.inside)
    return replace(
        first,
        clicks=clicks,
        boundary=boundary,
        gaps=tuple(gap for item in (first, second) for gap in item.gaps if lies_on(gap, boundary)),
        confidence=float(np.average((first.confidence, second.confidence), weights=lengths)),
        strength=float(np.average((first.strength, second.strength), weights=lengths)),
    )


def _signed(item: SegmentedObject, places: Array) -> Array:
    """Distance of places, shape (N, 2), from the boundary of an object, negative inside, shape (N,) [px]."""
    away = polyline.distances_from_closed(item.boundary, places)
    return np.asarray(np.where(item.encloses(places), -away, away))


def lies_on(gap: Line, boundary: tuple[Line, ...]) -> bool:
    """Whether most of a stretch lies on a boundary."""
    probes = polyline.middles(np.asarray(gap), 8)
    away = polyline.distances_from_closed(boundary, probes)
    return bool(np.median(away) <= _NEAR)


def _line(points: Array) -> Line:
    return tuple((row, col) for row, col in np.round(points, 3).tolist())
