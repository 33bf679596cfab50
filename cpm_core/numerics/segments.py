"""Straight segments in the plane: how far off places lie, where segments cross, and which places a polygon holds.

Whether two segments meet and whether a polygon winds around a place is decided by the same signed area, `side`, in
compiled loops: a step of a run asks for thousands of them.
"""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask

_PIECE = 1.0
"""Length that segments are cut down to, so that the nearest can be found by their middles [px]."""


def segments_of(path: Array) -> Array:
    """Segments, shape (K - 1, 4), of a path of shape (K, 2), those without length left out.

    A row holds row and column of one end, then of the other [px].
    """
    segments = np.concatenate([path[:-1], path[1:]], axis=1)
    return np.asarray(segments[(segments[:, :2] != segments[:, 2:]).any(axis=1)])


def distances_to_segments(points: Array, begin: Array, along: Array) -> Array:
    """Distance of each point from the segment that belongs to it.

    Parameters
    ----------
    points, begin, along : ndarray, shapes (..., 2) that go together
        Places, one end of each segment, and the vector from it to the other end, which may be zero [px].

    Returns
    -------
    ndarray, shape (...)
        Distances [px].
    """
    offset = points - begin
    square = np.einsum("...i,...i->...", along, along)
    share = np.einsum("...i,...i->...", offset, along) / np.where(square > 0.0, square, 1.0)
    away = offset - np.clip(share, 0.0, 1.0)[..., None] * along
    return np.asarray(np.hypot(away[..., 0], away[..., 1]))


def nearest_distances(points: Array, begin: Array, along: Array) -> Array:
    """Distance of each of points, shape (N, 2), from the nearest of segments, shapes (S, 2), shape (N,) [px].

    `SegmentTree` is faster where there are many of both.
    """
    nearest = np.full(len(points), np.inf)
    if len(points) < len(begin):
        for index, point in enumerate(points):
            nearest[index] = distances_to_segments(point, begin, along).min()
        return nearest
    for one, vector in zip(begin, along, strict=True):
        np.minimum(nearest, distances_to_segments(points, one, vector), out=nearest)
    return nearest


class SegmentTree:
    """Segments that many distances are measured to.

    Parameters
    ----------
    begin, end : ndarray, shape (S, 2)
        Ends of the segments [px].
    """

    def __init__(self, begin: Array, end: Array) -> None:
        pieces = np.maximum(1, np.ceil(np.linalg.norm(end - begin, axis=1) / _PIECE)).astype(int)
        side = np.repeat(np.arange(len(begin)), pieces)
        nth = (np.arange(len(side)) - np.repeat(np.cumsum(pieces) - pieces, pieces))[:, None]
        self._along = ((end - begin) / pieces[:, None])[side]
        self._begin = begin[side] + nth * self._along
        self._tree = scipy.spatial.cKDTree(self._begin + 0.5 * self._along) if len(side) else None

    def distances(self, points: Array) -> Array:
        """Distance of points, shape (N, 2), from the nearest segment, shape (N,) [px]; infinite when there is none."""
        least = np.full(len(points), np.inf)
        if self._tree is None or not len(points):
            return least
        left, near = np.arange(len(points)), 4
        while len(left):
            near = min(near, self._tree.n)
            middles, pieces = map(np.asarray, self._tree.query(points[left], k=np.arange(1, near + 1)))
            away = distances_to_segments(points[left][:, None], self._begin[pieces], self._along[pieces])
            least[left] = away.min(axis=1)
            # A piece that was not looked at has its middle beyond the last one, and reaches half its length nearer.
            left = left[middles[:, -1] - 0.5 * _PIECE < least[left]] if near < self._tree.n else left[:0]
            near *= 4
        return least


def cut(segment: Array, others: Array, tolerance: float) -> Array:
    """Pieces of a segment between the places where others cross or touch it.

    `meet` only tells that segments cross; this tells where.

    Parameters
    ----------
    segment : ndarray, shape (4,)
        The segment to cut [px].
    others : ndarray, shape (S, 4)
        Segments that may cross it [px].
    tolerance : float
        Distance within which the end of another lies on its line [px].

    Returns
    -------
    ndarray, shape (P, 4)
        The pieces in order.
    """
    a, along = segment[:2], segment[2:] - segment[:2]
    p, d = others[:, :2] - a, others[:, 2:] - others[:, :2]
    turn = along[0] * d[:, 1] - along[1] * d[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        at = (p[:, 0] * d[:, 1] - p[:, 1] * d[:, 0]) / turn
        on_other = (p[:, 0] * along[1] - p[:, 1] * along[0]) / turn
    crossing = at[(turn != 0.0) & (on_other >= 0.0) & (on_other <= 1.0)]
    # segments on one line do not cross: they part at their ends
    away = np.abs(p[:, 0] * along[1] - p[:, 1] * along[0]) / np.linalg.norm(along)
    ends = (p @ along / (along @ along))[away < tolerance]
    every = np.unique(np.concatenate([crossing, ends, [0.0, 1.0]]))
    every = every[(every >= 0.0) & (every <= 1.0)]
    places = a + every[:, None] * along
    places[-1] = segment[2:]
    return segments_of(places)


@compiled
def side(p: Array, q: Array, a: Array) -> float:
    """On which side of the line through p and q a place lies: twice the signed area of the triangle p, q, a [px²]."""
    turn: float = (q[0] - p[0]) * (a[1] - p[1]) - (q[1] - p[1]) * (a[0] - p[0])
    return turn


@compiled
def meet(segment: Array, a: Array, b: Array) -> bool:
    """Whether a segment, shape (4,), and the straight way from a to b have a place in common; touching counts."""
    if (
        max(a[0], b[0]) < min(segment[0], segment[2])
        or min(a[0], b[0]) > max(segment[0], segment[2])
        or max(a[1], b[1]) < min(segment[1], segment[3])
        or min(a[1], b[1]) > max(segment[1], segment[3])
    ):
        return False
    p, q = segment[:2], segment[2:]
    return side(p, q, a) * side(p, q, b) <= 0.0 and side(a, b, p) * side(a, b, q) <= 0.0


@compiled
def first_meeting(path: Array, segments: Array) -> tuple[int, int]:
    """First segment of a path, shape (K, 2), that meets one of others, shape (S, 4), and which; -1 for none."""
    for n in range(len(path) - 1):
        for s in range(len(segments)):
            if meet(segments[s], path[n], path[n + 1]):
                return n, s
    return -1, -1


@compiled
def winds_around(corners: Array, points: Array) -> Mask:
    """Which points, shape (N, 2), a polygon of shape (K, 2) winds around, its last corner joined to its first.

    By the winding number and not by the parity of crossings: a polygon that crosses itself has no holes.
    """
    inside = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        turns = 0
        before = len(corners) - 1
        for k in range(len(corners)):
            a, b = corners[before], corners[k]
            if a[0] <= points[i, 0] < b[0] and side(a, b, points[i]) > 0.0:
                turns += 1
            elif b[0] <= points[i, 0] < a[0] and side(a, b, points[i]) < 0.0:
                turns -= 1
            before = k
        inside[i] = turns != 0
    return inside
