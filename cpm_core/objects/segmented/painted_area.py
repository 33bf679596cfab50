"""The area of an object that is painted with a round brush: its boundary changes only where the brush is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import skimage

from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Index, Mask, Position
from cpm_core.objects.segmented.segmented_object import Line

_BAND = 3.0
"""Distance from the edge of the brush up to which distances are exact [px]."""

_FAR = 1.5
"""Distance from the brush from which on the boundary stays as it was [px]."""

_MARGIN = 2
"""Width around an area in which it is looked for [px]."""

_UNSURE = 0.4
"""Distance from the boundary up to which a pixel may come to lie on either side of it [px]."""

_PROBES = 200
"""Places of a path that are compared with another one."""

_LEAST_AREA = 0.5
"""Area below which an island or a hole is a remainder of the painting [px²]."""


@dataclass(frozen=True, eq=False)
class PaintedArea:
    """What closed curves enclose, as it is painted.

    Attributes
    ----------
    boundary : tuple of tuple
        Closed curves of vertices (row, col) [px], the first vertex not repeated. A place is inside when an odd number
        of them encloses it.
    shape : tuple of int
        Shape of the image, at whose border what is painted ends.
    known : tuple
        First pixel of a window around the boundary, and which pixels of it are inside, where that is known.
    """

    boundary: tuple[Line, ...]
    shape: tuple[int, ...]
    known: tuple[Index, Mask] | None = None

    def painted(self, path: Sequence[Position], radius: float, adds: bool) -> PaintedArea:
        """The area with, or without, what a disk of a radius goes over along a path [px].

        The new boundary is where the smaller of the signed distances from the area and from the brush is zero, or the
        larger one where the brush takes away. Farther from the brush it has the very vertices that it had before.
        """
        brush = _Brush(np.array(path, dtype=float).reshape(-1, 2), radius)
        first, inside = self._window(brush)
        part = brush.slices(first, inside.shape)
        level = np.where(inside, -0.5, 0.5)
        level[part] = self._level(level[part], brush, first + [one.start for one in part], adds, _BAND)
        curves = _stitched(_curves(level, first), self.boundary, brush)
        found = () if curves is None else _boundary(curves)
        filled = _filled(found, first, inside.shape)
        if curves is None or ((filled != (level < 0.0)) & (np.abs(level) > _UNSURE)).any():
            level = self._level(np.where(inside, -0.5, 0.5), brush, first, adds, np.inf)
            found = _boundary(_curves(level, first))
            filled = _filled(found, first, inside.shape)
        return PaintedArea(found, self.shape, (first, filled))

    def _level(self, level: Array, brush: _Brush, first: Index, adds: bool, band: float) -> Array:
        """Signed distances from the painted area in a window, below 0 inside; exact in a band at the edge of the brush.

        `level` has the sides of the former area, and `first` is the first pixel.
        """
        places = np.indices(level.shape).reshape(2, -1).T + first.astype(float)
        beyond = brush.distances(places)
        if adds:
            low, high = -0.5 - places, places - (np.array(self.shape) - 0.5)
            beyond = np.maximum(beyond, np.maximum(low, high).max(axis=1))
        exact, away = np.abs(beyond) <= band, level.ravel().copy()
        if self.boundary:
            away[exact] = np.copysign(polyline.distances_from_closed(self.boundary, places[exact]), away[exact])
        else:
            away[exact] = _BAND
        return np.asarray(np.minimum(away, beyond) if adds else np.maximum(away, -beyond)).reshape(level.shape)

    def _window(self, brush: _Brush) -> tuple[Index, Mask]:
        """First pixel of a window around area and brush, and which pixels of it are inside."""
        known, was = self._inside
        low = np.floor(brush.path.min(axis=0) - brush.radius).astype(np.intp) - _MARGIN
        high = np.ceil(brush.path.max(axis=0) + brush.radius).astype(np.intp) + _MARGIN + 1
        if was.size:
            low, high = np.minimum(low, known), np.maximum(high, known + was.shape)
        inside = np.zeros(tuple(high - low), np.bool_)
        at = known - low
        inside[at[0] : at[0] + was.shape[0], at[1] : at[1] + was.shape[1]] = was
        return low, inside

    @cached_property
    def _inside(self) -> tuple[Index, Mask]:
        """First pixel of a window around the area, and which pixels of it are inside."""
        if self.known is not None:
            return self.known
        if not self.boundary:
            return np.zeros(2, np.intp), np.zeros((0, 0), np.bool_)
        corners = np.concatenate([np.array(curve) for curve in self.boundary])
        low = np.floor(corners.min(axis=0)).astype(np.intp) - _MARGIN
        size = np.ceil(corners.max(axis=0)).astype(np.intp) + _MARGIN + 1 - low
        return low, _filled(self.boundary, low, tuple(size.tolist()))


@dataclass(frozen=True, eq=False)
class _Brush:
    """A disk that goes along a path, shape (K, 2) [px]."""

    path: Array
    radius: float

    def distances(self, places: Array) -> Array:
        """Distances of places, shape (N, 2), from the edge of what it goes over, negative inside, shape (N,)."""
        return polyline.distances(self.path, places) - self.radius

    def slices(self, first: Index, shape: tuple[int, ...]) -> tuple[slice, ...]:
        """The part of a window, whose first pixel is given, in which it changes something."""
        reach = self.radius + _BAND + 1.0
        low = np.clip(np.floor(self.path.min(axis=0) - reach) - first, 0, shape).astype(int)
        high = np.clip(np.ceil(self.path.max(axis=0) + reach) - first + 1, 0, shape).astype(int)
        return tuple(map(slice, low.tolist(), high.tolist()))

    def far_from(self, places: Array) -> Mask:
        """Which places, shape (N, 2), lie where it changes nothing."""
        return np.asarray(self.distances(places) > _FAR)


def _stitched(curves: Sequence[Array], boundary: Sequence[Line], brush: _Brush) -> list[Array] | None:
    """Curves that run along a former boundary wherever they are far from the brush; None where it is not clear how."""
    former = [np.array(curve) for curve in boundary]
    kept = {at for at, curve in enumerate(former) if brush.far_from(polyline.sampled(_closed(curve), 0.5)).all()}
    found, passed, used = [], set(), set()
    for curve in curves:
        far = brush.far_from(curve)
        if far.all():
            passed |= {_nearest(former, curve[0])[0]}
            continue
        stretches = []
        for stretch, is_far in _parted(curve, far):
            at, along = _along(former, stretch) if is_far else (-1, stretch)
            if along is None:
                return None
            used.add(at)
            stretches.append(along)
        found.append(np.concatenate(stretches))
    return [*found, *(former[at] for at in sorted((kept | passed) - used))]


def _parted(curve: Array, far: Mask) -> list[tuple[Array, bool]]:
    """The stretches of a closed curve that are near the brush and far from it, in turn."""
    first = int(np.argmin(far))  # near it, so that no stretch goes on from the end to the beginning
    curve, far = np.roll(curve, -first, axis=0), np.roll(far, -first)
    cuts = np.flatnonzero(np.diff(far.astype(int))) + 1
    return [(stretch, number % 2 == 1) for number, stretch in enumerate(np.split(curve, cuts))]


def _along(former: Sequence[Array], stretch: Array) -> tuple[int, Array | None]:
    """Number of the curve that a stretch runs along, and what it is of it; None where its ends run along two."""
    at, begin, first = _nearest(former, stretch[0])
    other, end, last = _nearest(former, stretch[-1])
    if at != other:
        return at, None
    curve = former[at]
    ways = (
        np.concatenate([[first], curve[_between(begin, end, len(curve))], [last]]),
        np.concatenate([[first], curve[_between(end, begin, len(curve))][::-1], [last]]),
    )
    return at, min(ways, key=lambda way: _apart(way, stretch))


def _apart(way: Array, other: Array) -> float:
    """How far the farther places of two paths are from the other path, added up [px]."""
    there = polyline.distances(way, polyline.middles(other, _PROBES) if len(other) > _PROBES else other)
    back = polyline.distances(other, polyline.middles(way, _PROBES))
    return float(there.max() + back.max())


def _between(begin: float, end: float, count: int) -> Index:
    """Numbers of the vertices of a closed curve of so many that lie after one place and not beyond another."""
    return np.arange(np.floor(begin) + 1, np.floor(begin + (end - begin) % count) + 1).astype(np.intp) % count


def _nearest(former: Sequence[Array], place: Array) -> tuple[int, float, Array]:
    """Number of the curve nearest to a place, the number of a vertex and the fraction to the next, and the point."""
    best = (0, 0.0, place)
    least = np.inf
    for at, curve in enumerate(former):
        side = np.roll(curve, -1, axis=0) - curve
        share = ((place - curve) * side).sum(axis=1) / np.maximum((side**2).sum(axis=1), 1e-12)
        share = np.clip(share, 0.0, 1.0)
        points = curve + share[:, None] * side
        away = np.hypot(*(points - place).T)
        index = int(np.argmin(away))
        if away[index] < least:
            least, best = away[index], (at, index + float(min(share[index], 1.0 - 1e-9)), points[index])
    return best


def _curves(level: Array, first: Index) -> list[Array]:
    """The closed curves along which a function on a window is zero."""
    lines = skimage.measure.find_contours(level, 0.0)  # type: ignore[no-untyped-call]
    return [line[:-1] + first for line in lines]


def _boundary(curves: Iterable[Array]) -> tuple[Line, ...]:
    """Curves as the boundary of an object, without remainders."""
    lines = (_line(curve) for curve in curves)
    return tuple(line for line in lines if len(set(line)) > 2 and polyline.area(line) >= _LEAST_AREA)


def _filled(boundary: Iterable[Line], first: Index, shape: tuple[int, ...]) -> Mask:
    """Which pixels of a window an odd number of curves encloses: each row changes sides where a curve crosses it."""
    crossed = np.zeros((shape[0], shape[1] + 1), np.int64)
    for curve in boundary:
        begin = np.array(curve) - first
        end = np.roll(begin, -1, axis=0)
        low, high = np.minimum(begin[:, 0], end[:, 0]), np.maximum(begin[:, 0], end[:, 0])
        rows = np.ceil(low).astype(np.intp)
        counts = np.maximum(
            np.ceil(high).astype(np.intp) - rows, 0
        )  # rows from the lower end up to below the upper one
        side = np.repeat(np.arange(len(begin)), counts)
        row = rows[side] + np.arange(len(side)) - np.repeat(np.cumsum(counts) - counts, counts)
        share = (row - begin[side, 0]) / (end[side, 0] - begin[side, 0])
        col = np.ceil(begin[side, 1] + share * (end[side, 1] - begin[side, 1])).astype(np.intp)
        seen = (row >= 0) & (row < shape[0])
        np.add.at(crossed, (row[seen], np.clip(col[seen], 0, shape[1])), 1)
    return np.asarray(np.cumsum(crossed, axis=1)[:, :-1] % 2 == 1)


def _closed(curve: Array) -> Array:
    return np.concatenate([curve, curve[:1]])


def _line(points: Array) -> Line:
    corners = [(row, col) for row, col in np.round(points, 3).tolist()]
    return tuple(
        corner for corner, before in zip(corners, corners[-1:] + corners[:-1], strict=True) if corner != before
    )
