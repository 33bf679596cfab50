"""Straight segments in the plane: distances, crossings, and the interior of polygons.

Whether two segments meet and whether a polygon winds around a position is decided by the same signed area,
`side_of_line`, in compiled loops, since a step of a run asks thousands of times.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import NO_POINTS, Array, Index, Mask, Position


def path_segments(path: Array) -> Array:
    """Return segments of a path, shapes (K - 1, 4) and (K, 2), without those of zero length.

    A row holds row and column of one end, then of the other [px].
    """
    segments = np.concatenate([path[:-1], path[1:]], axis=1)
    return segments[(segments[:, :2] != segments[:, 2:]).any(axis=1)]


def distances_to_segments(points: Array, begin: Array, along: Array) -> Array:
    """Return the distance of each point from the segment that belongs to it, shape (...) [px].

    `points`, `begin` and `along` have shapes (..., D) that broadcast: the points, one end of each segment, and the
    vector from it to the other end, which may be zero.
    """
    offset = points - begin
    square = np.einsum("...i,...i->...", along, along)
    share = np.einsum("...i,...i->...", offset, along) / np.where(square > 0.0, square, 1.0)
    away = offset - np.clip(share, 0.0, 1.0)[..., None] * along
    return np.linalg.norm(away, axis=-1)


class SegmentTree:
    """Segments with ends `begin` and `end`, shape (S, 2) [px], for many measurements of distances."""

    def __init__(self, begin: Array, end: Array) -> None:
        import shapely  # noqa: PLC0415 - takes long to load

        # GEOS knows no distance from a line without length
        short = ((end - begin) ** 2).sum(axis=1) == 0.0
        lines = shapely.linestrings(np.stack([begin, end], axis=1))
        self._tree = shapely.STRtree(np.where(short, shapely.points(begin), lines))

    def distances_to(self, points: Array) -> Array:
        """Return the distance, shape (N,) [px], of points, shape (N, 2), from the nearest segment; inf for none."""
        import shapely  # noqa: PLC0415

        least = np.full(len(points), np.inf)
        if len(self._tree):
            nearest = self._tree.query_nearest(shapely.points(points), return_distance=True, all_matches=False)
            least[nearest[0][0]] = nearest[1]
        return least


class PathTree:
    """Paths, each of shape (K, 2) [px], indexed to find those near a position."""

    def __init__(self, paths: Sequence[Array]) -> None:
        import shapely  # noqa: PLC0415 - takes long to load

        # GEOS knows no distance from a line without length
        counts = np.array([len(path) for path in paths], int)
        corners, first = np.concatenate([NO_POINTS, *paths]), np.cumsum(counts) - counts
        long = np.logical_or.reduceat((corners != np.repeat(corners[first], counts, axis=0)).any(axis=1), first)
        self._lines = shapely.points(corners[first])
        of = np.repeat(np.arange(long.sum()), counts[long])
        self._lines[long] = shapely.linestrings(corners[np.repeat(long, counts)], indices=of)
        self._tree = shapely.STRtree(self._lines)

    def pairs_within(self, places: Array, reach: float) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
        """Find the pairs of a position, shape (N, 2), and a path within `reach` [px] of it.

        Returns the indices of position and path, and their distance [px], each of shape (P,).
        """
        import shapely  # noqa: PLC0415

        points = shapely.points(places)
        place, path = self._tree.query(points, "dwithin", reach)
        return place, path, shapely.distance(points[place], self._lines[path])

    def paths_near(self, place: Position, reach: float) -> list[int]:
        """Return indices of the paths within `reach` [px] of a position, nearest first."""
        _, path, away = self.pairs_within(np.array([place]), reach)
        return list(path[np.lexsort((path, away))].tolist())


def _signed_area(p: Array, q: Array, a: Array) -> Any:
    """Return twice the signed area of the triangle p, q, a [px²]: by its sign, the side of the line through p and q."""
    return (q[0] - p[0]) * (a[1] - p[1]) - (q[1] - p[1]) * (a[0] - p[0])


side_of_line = compiled(_signed_area)
"""Signed area whose sign is the side of the line through p and q that a position a lies on."""


@compiled
def segments_meet(segment: Array, a: Array, b: Array) -> bool:
    """Return whether a segment, shape (4,), meets the one from a to b, shape (2,); touching counts."""
    if (
        max(a[0], b[0]) < min(segment[0], segment[2])
        or min(a[0], b[0]) > max(segment[0], segment[2])
        or max(a[1], b[1]) < min(segment[1], segment[3])
        or min(a[1], b[1]) > max(segment[1], segment[3])
    ):
        return False
    p, q = segment[:2], segment[2:]
    return side_of_line(p, q, a) * side_of_line(p, q, b) <= 0.0 and side_of_line(a, b, p) * side_of_line(a, b, q) <= 0.0


def first_crossing(path: Array, segments: Array) -> tuple[int, int]:
    """Return the first segment of a path, shape (K, 2), that meets one of others, shape (S, 4), and which one; else -1.

    It uses the formula of `side_of_line`, but in NumPy: a compiled loop may round a product and a sum as one, so that
    it does not always find that a path which ends on a vertex of the others touches them.
    """
    p, q = segments[:, :2].T, segments[:, 2:].T
    low, high = path.min(axis=0)[:, None], path.max(axis=0)[:, None]
    near = np.flatnonzero((np.maximum(p, q) >= low).all(axis=0) & (np.minimum(p, q) <= high).all(axis=0))
    p, q = p[:, near], q[:, near]
    for n, (a, b) in enumerate(pairwise(path)):
        apart = _signed_area(p, q, a) * _signed_area(p, q, b), _signed_area(a, b, p) * _signed_area(a, b, q)
        crossing = np.flatnonzero((apart[0] <= 0.0) & (apart[1] <= 0.0))
        if len(crossing):
            return n, int(near[crossing[0]])
    return -1, -1


def winds_around(corners: Array, points: Array) -> Mask:
    """Return a mask, shape (N,), of the points, shape (N, 2), that a closed polygon, shape (K, 2), winds around.

    The polygon is closed from its last corner to its first. The winding number decides, not the parity of crossings: a
    polygon that crosses itself has no holes.
    """
    order = np.argsort(points[:, 0], kind="stable")
    rows = points[order, 0]
    from_, to = np.roll(corners, 1, axis=0), corners
    first = np.searchsorted(rows, np.minimum(from_[:, 0], to[:, 0]))
    last = np.searchsorted(rows, np.maximum(from_[:, 0], to[:, 0]))
    inside = np.empty(len(points), bool)
    inside[order] = _winding_numbers(from_, to, points[order], first, last) != 0
    return inside


@compiled
def _winding_numbers(from_: Array, to: Array, points: Array, first: Index, last: Index) -> Index:
    """Return the winding number of a polygon around points in ascending order of their rows.

    `first` and `last`, shape (K,), are the points at whose height each side is.
    """
    turns = np.zeros(len(points), np.int64)
    for k in range(len(from_)):
        for i in range(first[k], last[k]):
            left = side_of_line(from_[k], to[k], points[i])
            if from_[k, 0] < to[k, 0] and left > 0.0:
                turns[i] += 1
            elif from_[k, 0] > to[k, 0] and left < 0.0:
                turns[i] -= 1
    return turns


def union_boundary(polygons: Sequence[Array]) -> Array:
    """Return the boundary, shape (S, 4), of the union of the areas that polygons, each of shape (K, 2), wind around."""
    import shapely  # noqa: PLC0415 - needed for regions of interest only

    inside = []
    for corners in polygons:
        line = shapely.union_all(shapely.LineString([*corners, corners[0]]))  # cut where it crosses itself
        pieces = shapely.get_parts(shapely.polygonize([line]))
        places = shapely.get_coordinates(shapely.point_on_surface(pieces))
        # first the pieces of one polygon, whose common sides are equal to the bit: else a crack might remain
        inside.append(shapely.union_all(pieces[winds_around(corners, places)]))
    rings = shapely.get_parts(shapely.boundary(shapely.union_all(inside)))
    return np.concatenate([np.zeros((0, 4)), *(path_segments(shapely.get_coordinates(ring)) for ring in rings)])
