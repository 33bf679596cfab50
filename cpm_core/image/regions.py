"""Regions of interest, which particles do not leave, and barriers, which they do not cross; the user draws both."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.image.pyramid import to_scale
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import Window
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.segments import SegmentTree, path_segments, segments_meet, union_boundary
from cpm_core.numerics.types import Array, Extent, Line, Mask, frozen
from cpm_core.parameters.formatting import format_count, format_repr, format_size, quote_value

_ON_LINE_DISTANCE = 1e-6
"""Distance within which a position counts as on a line [px]."""

_CACHED_POLYGONS = 8
"""Number of polygons whose pixels and boundaries are cached: while a barrier is dragged they are needed repeatedly."""


@frozen
class Regions:
    """Part of an image in which particles may be.

    They stay inside the union of the regions of interest, and never cross a barrier. Outside the regions of interest
    pixels carry no fixed charge and do not count in the statistics of the edge strength.

    Parameters
    ----------
    interest : sequence of polygons
        Corners (row, col) [px] of each, at least three. A polygon contains what it winds around, so that a polygon that
        crosses itself has no holes. Without any, the whole image is of interest.
    barriers : sequence of polygonal lines
        Vertices (row, col) [px] of each, at least two; they may lie outside the image.

    Raises
    ------
    ValueError
        For too few corners or values that are not finite.

    Examples
    --------
    >>> left = cpm.Regions(interest=[[(0, 0), (63, 0), (63, 31), (0, 31)]], barriers=[[(0, 20), (63, 20)]])
    >>> left
    <Regions 1 region of interest, 1 barrier>
    >>> left.check_shape((64, 64))
    >>> left.contains(np.array([(32.0, 10.0), (32.0, 50.0)])).tolist(), left.allows(np.array([(32.0, 20.0)])).tolist()
    ([True, False], [False])
    >>> int(left.pixel_mask((64, 64)).sum()), left.rim_segments().shape, left.barrier_segments().shape
    (1953, (4, 4), (1, 4))
    >>> left.at_scale(1, (64, 64)).interest[0][1]
    (31.25, -0.25)
    """

    interest: tuple[Line, ...] = ()
    barriers: tuple[Line, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "interest", _check_lines("region of interest", self.interest, 3))
        object.__setattr__(self, "barriers", _check_lines("barrier", self.barriers, 2))

    def check_shape(self, shape: Extent) -> None:
        """Raise a `ValueError` unless every region of interest contains a pixel of an image of this shape."""
        if len(shape) != 2:
            raise ValueError(
                f"these regions are for an image, but this is a volume of {format_size(shape, '')}: use VolumeRegions."
            )
        for number, polygon in enumerate(self.interest, start=1):
            if not pixels_in_polygon(polygon, shape).any():
                raise ValueError(
                    f"region of interest {number} contains no pixel of the image ({format_size(shape, 'pixels')}): "
                    "draw it inside the image, around an object."
                )

    def at_scale(self, scale: int, shape: Extent) -> Regions:
        """Return the regions of an image of shape `shape`, in px of one of its scales."""
        parts = (
            [to_scale(polyline.corners_of(line), scale, shape) for line in lines]
            for lines in (self.interest, self.barriers)
        )
        return Regions(*(tuple(as_line(points) for points in part) for part in parts))

    def contains(self, points: Array) -> Mask:
        """Return whether points, shape (N, 2) [px], lie in a region of interest; all do where there is none."""
        if not self.interest:
            return np.ones(len(points), bool)
        return np.any([polyline.points_inside(polygon, points) for polygon in self.interest], axis=0)

    def allows(self, points: Array) -> Mask:
        """Return whether particles may be at points, shape (N, 2) [px]: in a region of interest, off all lines."""
        lines = np.concatenate([self.rim_segments(), self.barrier_segments()])
        away = SegmentTree(lines[:, :2], lines[:, 2:]).distances_to(points)
        return self.contains(points) & (away >= _ON_LINE_DISTANCE)

    def pixel_mask(self, shape: Extent) -> Mask:
        """Mark the pixels of an image of this shape whose center lies in a region of interest."""
        if not self.interest:
            return np.ones(shape, bool)
        return np.any([pixels_in_polygon(polygon, shape) for polygon in self.interest], axis=0)

    def rim_segments(self) -> Array:
        """Return the boundary of the union of the regions of interest as segments, shape (S, 4) [px]."""
        return _union_rim(self.interest)

    def barrier_segments(self) -> Array:
        """Return the barriers as segments, shape (S, 4) [px]."""
        return np.concatenate([np.zeros((0, 4)), *(path_segments(polyline.corners_of(line)) for line in self.barriers)])

    def __repr__(self) -> str:
        interest = format_count(len(self.interest), "region of interest", "regions of interest")
        return format_repr("Regions", interest, format_count(len(self.barriers), "barrier"))


def _check_lines(noun: str, lines: Iterable[Iterable[Sequence[float]]], least: int) -> tuple[Line, ...]:
    """Check lines, and convert them to tuples."""
    checked = []
    if not isinstance(lines, Iterable) or (isinstance(lines, np.ndarray) and lines.ndim == 0):
        raise ValueError(f"each {noun} must be a sequence of points, not {quote_value(lines)}: give a list of them.")
    for number, line in enumerate(lines, start=1):
        what = f"{noun} {number}"
        try:
            points = polyline.corners_of([tuple(point) for point in line])
        except (TypeError, ValueError):
            points = np.zeros(0)
        if points.ndim != 2 or points.shape[1] != 2:
            raise ValueError(f"{what} must be a sequence of at least {least} points (row, col).")
        if not np.isfinite(points).all():
            raise ValueError(f"{what} has coordinates that are not finite: give numbers of rows and columns.")
        corners = as_line(points)
        different = len(set(corners))
        if different < least:
            raise ValueError(f"{what} has {different} different points but must have at least {least}.")
        checked.append(corners)
    return tuple(checked)


@lru_cache(maxsize=_CACHED_POLYGONS)
def pixels_in_polygon(polygon: Line, shape: Extent) -> Mask:
    """Mark the pixels of an image of this shape whose center lies in a polygon."""
    places = np.indices(shape).reshape(2, -1).T.astype(float)
    return polyline.points_inside(polygon, places).reshape(shape)


@lru_cache(maxsize=_CACHED_POLYGONS)
def _union_rim(interest: tuple[Line, ...]) -> Array:
    """Compute the rim of the union of polygons; see `Regions.rim_segments`."""
    return union_boundary([polyline.corners_of(polygon) for polygon in interest])


_BARRIER_SAMPLING = 0.5
"""Distance of the points along a barrier that mark its pixels [px]."""

_MAX_CLEARANCE = 12
"""Largest distance that is measured [px]: few moves are as long."""

_CLEARANCE_ERROR = 2.0
"""Largest error of a distance that is measured between pixels instead of points: half a diagonal twice, and half the
sampling [px]."""


class BarrierMap(NamedTuple):
    """The barriers of one scale; a plain tuple for the compiled loops.

    Attributes
    ----------
    segments : ndarray, shape (S, 4)
        Row and column of one end, then of the other [px of the scale].
    clearance : ndarray, shape (H, W)
        Lower bound of the distance from any point of a pixel to the nearest barrier [px]; may be below 0.
    """

    segments: Array
    clearance: Array

    def is_crossed_by(self, start: Array, end: Array) -> Mask:
        """Return whether straight moves from `start` to `end`, shapes (N, 2) [px], cross or touch a barrier."""
        if not len(self.segments):
            return np.zeros(len(start), bool)
        return _find_crossings(self, np.ascontiguousarray(start, float), np.ascontiguousarray(end, float))

    def crop_to_window(self, window: Window) -> BarrierMap:
        """Crop the barriers to a window of the image."""
        if not len(self.segments):
            return self
        return BarrierMap(self.segments - 2 * [side.start for side in window], self.clearance[window].copy())


NO_BARRIERS = BarrierMap(np.zeros((0, 4)), np.zeros((1, 1)))


def build_barrier_map(regions: Regions, shape: Extent) -> BarrierMap:
    """Build the map of barriers and boundaries of `regions`, in px of the scale, for an image of this shape."""
    segments = np.concatenate([regions.rim_segments(), regions.barrier_segments()])
    if not len(segments):
        return NO_BARRIERS
    import shapely  # noqa: PLC0415 - needed for regions and barriers only

    sides = shapely.segmentize(shapely.linestrings(segments.reshape(-1, 2, 2)), _BARRIER_SAMPLING)
    pixels = np.rint(shapely.get_coordinates(sides)).astype(int)
    pixels = pixels[((pixels >= -1) & (pixels <= shape)).all(axis=1)]
    free = np.ones(shape, bool)
    free[tuple(np.clip(pixels, 0, np.array(shape) - 1).T)] = False
    # along the axis on which it is longer: never more than the distance itself
    clearance = (
        np.full(shape, _MAX_CLEARANCE) if free.all() else scipy.ndimage.distance_transform_cdt(free, "chessboard")
    )
    return BarrierMap(segments, np.minimum(clearance, _MAX_CLEARANCE) - _CLEARANCE_ERROR)


@compiled
def crosses_barrier(barrier_map: BarrierMap, a: Array, b: Array) -> bool:
    """Return whether the straight line from a to b, shapes (2,), crosses or touches a barrier."""
    if len(barrier_map.segments) == 0:
        return False
    rows, cols = barrier_map.clearance.shape
    row = min(max(np.int64(a[0] + 0.5), 0), rows - 1)
    col = min(max(np.int64(a[1] + 0.5), 0), cols - 1)
    clear = barrier_map.clearance[row, col]
    if clear > 0.0 and (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 < clear * clear:
        return False
    s = 0
    while s < len(barrier_map.segments) and not segments_meet(barrier_map.segments[s], a, b):
        s += 1
    return s < len(barrier_map.segments)


@compiled
def _find_crossings(barrier_map: BarrierMap, start: Array, end: Array) -> Mask:
    out = np.zeros(len(start), np.bool_)
    for i in range(len(start)):
        out[i] = crosses_barrier(barrier_map, start[i], end[i])
    return out
