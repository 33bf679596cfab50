"""Straight segments in the plane: distances, crossings, and which positions lie inside a polygon.

Whether two segments meet and whether a polygon winds around a position is decided by the same signed area, `side`, in
compiled loops, since a step of a run asks thousands of times.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask

_MOST_BANDS = 4096
"""Largest number of bands into which the sides of a polygon are sorted."""

_FEW = 64
"""Points up to which all sides of a polygon are tested for each."""

_PIECE = 1.0
"""Length of the pieces that segments are cut into, so that the nearest can be found by their midpoints [px]."""


def segments_of(path: Array) -> Array:
    """Segments of a path, shapes (K - 1, 4) and (K, 2), without those of zero length.

    A row holds row and column of one end, then of the other [px].
    """
    segments = np.concatenate([path[:-1], path[1:]], axis=1)
    return np.asarray(segments[(segments[:, :2] != segments[:, 2:]).any(axis=1)])


def distances_to_segments(points: Array, begin: Array, along: Array) -> Array:
    """Distance of each point from the segment that belongs to it, shape (...) [px].

    `points`, `begin` and `along` have shapes (..., 2) that broadcast: the points, one end of each segment, and the
    vector from it to the other end, which may be zero.
    """
    offset = points - begin
    square = np.einsum("...i,...i->...", along, along)
    share = np.einsum("...i,...i->...", offset, along) / np.where(square > 0.0, square, 1.0)
    away = offset - np.clip(share, 0.0, 1.0)[..., None] * along
    return np.asarray(np.hypot(away[..., 0], away[..., 1]))


@compiled
def nearest_distances(points: Array, segments: Array) -> Array:
    """Distance of each of points, shape (N, 2), from the nearest of segments, shape (S, 4), shape (N,) [px].

    The loop over all pairs of `distances_to_segments`; `SegmentTree` is faster where there are many of both.
    """
    nearest = np.full(len(points), np.inf)
    for i in range(len(points)):
        for s in range(len(segments)):
            down, right = segments[s, 2] - segments[s, 0], segments[s, 3] - segments[s, 1]
            row, col = points[i, 0] - segments[s, 0], points[i, 1] - segments[s, 1]
            square = down * down + right * right
            share = min(max((row * down + col * right) / square, 0.0), 1.0) if square > 0.0 else 0.0
            nearest[i] = min(nearest[i], (row - share * down) ** 2 + (col - share * right) ** 2)
        nearest[i] = np.sqrt(nearest[i])
    return nearest


class SegmentTree:
    """Segments with ends `begin` and `end`, shape (S, 2) [px], for many measurements of distances."""

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
            # The midpoint of a piece that was not found is farther than the last one; its end is half a length nearer.
            left = left[middles[:, -1] - 0.5 * _PIECE < least[left]] if near < self._tree.n else left[:0]
            near *= 4
        return least


def cut(segment: Array, others: Array, tolerance: float) -> Array:
    """Pieces of a segment, shape (4,), between the places where others, shape (S, 4), cross or touch it, shape (P, 4).

    `meet` decides whether segments cross; this function finds where. The end of another segment lies on the line of
    this one within the distance `tolerance` [px]. The pieces come in order.
    """
    a, along = segment[:2], segment[2:] - segment[:2]
    p, d = others[:, :2] - a, others[:, 2:] - others[:, :2]
    turn = along[0] * d[:, 1] - along[1] * d[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        at = (p[:, 0] * d[:, 1] - p[:, 1] * d[:, 0]) / turn
        on_other = (p[:, 0] * along[1] - p[:, 1] * along[0]) / turn
    crossing = at[(turn != 0.0) & (on_other >= 0.0) & (on_other <= 1.0)]
    # segments on one line do not cross: they are cut at their ends
    away = np.abs(p[:, 0] * along[1] - p[:, 1] * along[0]) / np.linalg.norm(along)
    ends = (p @ along / (along @ along))[away < tolerance]
    every = np.unique(np.concatenate([crossing, ends, [0.0, 1.0]]))
    every = every[(every >= 0.0) & (every <= 1.0)]
    places = a + every[:, None] * along
    places[-1] = segment[2:]
    return segments_of(places)


def _signed_area(p: Array, q: Array, a: Array) -> Any:
    """Twice the signed area of the triangle p, q, a [px²]: by its sign, the side of the line through p and q."""
    return (q[0] - p[0]) * (a[1] - p[1]) - (q[1] - p[1]) * (a[0] - p[0])


side = compiled(_signed_area)
"""On which side of the line through p and q a position a lies, by the sign."""


@compiled
def meet(segment: Array, a: Array, b: Array) -> bool:
    """Whether a segment, shape (4,), and the straight line from a to b have a point in common; touching counts."""
    if (
        max(a[0], b[0]) < min(segment[0], segment[2])
        or min(a[0], b[0]) > max(segment[0], segment[2])
        or max(a[1], b[1]) < min(segment[1], segment[3])
        or min(a[1], b[1]) > max(segment[1], segment[3])
    ):
        return False
    p, q = segment[:2], segment[2:]
    meeting: bool = side(p, q, a) * side(p, q, b) <= 0.0 and side(a, b, p) * side(a, b, q) <= 0.0
    return meeting


def first_crossing(path: Array, segments: Array) -> tuple[int, int]:
    """First segment of a path, shape (K, 2), that crosses or touches one of others, shape (S, 4), and which; or -1.

    It uses the formula of `side`, but in NumPy: a compiled loop may round a product and a sum as one, so that it does
    not always find that a path which ends on a vertex of the others touches them.
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


class Bands:
    """Bands across the plane, at most `most`, with the sides that reach into each, given first and last row of sides.

    Attributes
    ----------
    sides : ndarray of int
        Sides of the first band, then of the second one, and so on.
    starts : ndarray of int
        Where in `sides` those of each band begin, and the end of the last one.
    first, last, height : float
        Row at which the first band begins, row at which the last one ends, and height of each [px].
    """

    def __init__(self, low: Array, high: Array, most: int = _MOST_BANDS) -> None:
        self.first, self.last = float(low.min()), float(high.max())
        mean = max(float((high - low).mean()), 1e-9)  # so that a side lies in few bands
        bands = int(min(max((self.last - self.first) / mean, 1.0), len(low), most))
        self.height = max((self.last - self.first) / bands, 1e-300)
        self._count = bands
        lowest, highest = self.of(low), self.of(high)
        spans = highest - lowest + 1
        band_of = np.arange(spans.sum()) - np.repeat(np.cumsum(spans) - spans - lowest, spans)
        self.sides = np.repeat(np.arange(len(low)), spans)[np.argsort(band_of, kind="stable")]
        self.starts = np.searchsorted(np.sort(band_of), np.arange(bands + 1))

    def between(self, low: float, high: float) -> NDArray[np.int64]:
        """The sides that may reach rows between two, in their order."""
        lowest, highest = self.of(np.array([low, high]))
        return np.unique(self.sides[self.starts[lowest] : self.starts[highest + 1]])

    def of(self, row: Array) -> NDArray[np.int64]:
        """Number of the band of each row.

        It is no compiled loop: one may multiply by the reciprocal instead of dividing, and then finds another band for
        a row between two, where the sides that begin at this row are missing.
        """
        return np.clip((row - self.first) / self.height, 0, self._count - 1).astype(np.int64)


def winds_around(corners: Array, points: Array) -> Mask:
    """Which points, shape (N, 2), a polygon of shape (K, 2) winds around, closed from its last corner to its first.

    The winding number decides, not the parity of crossings: a polygon that crosses itself has no holes. Only the sides
    at the height of a point are tested.
    """
    begin, end = np.roll(corners[:, 0], 1), corners[:, 0]
    # sorting the sides takes as long as testing a few points against all of them
    bands = Bands(np.minimum(begin, end), np.maximum(begin, end), 1 if len(points) < _FEW else _MOST_BANDS)
    near = np.flatnonzero((points[:, 0] >= bands.first) & (points[:, 0] <= bands.last))
    inside = np.zeros(len(points), np.bool_)
    places = points[near]
    inside[near] = _winds_around(corners, places, bands.of(places[:, 0]), bands.sides, bands.starts)
    return inside


@compiled
def _winds_around(corners: Array, points: Array, numbers: Any, sides: Any, starts: Any) -> Mask:
    """See `winds_around`; `numbers` are the bands of the points, whose `sides` lie between two entries of `starts`."""
    inside = np.zeros(len(points), np.bool_)
    for i in range(len(points)):
        turns = 0
        for s in range(starts[numbers[i]], starts[numbers[i] + 1]):
            k = sides[s]
            before = k - 1 if k else len(corners) - 1
            below, above = corners[before, 0] <= points[i, 0], corners[k, 0] <= points[i, 0]
            if below != above:  # true for few sides, which saves most calls
                left = side(corners[before], corners[k], points[i])
                if below and left > 0.0:
                    turns += 1
                elif above and left < 0.0:
                    turns -= 1
        inside[i] = turns != 0
    return inside
