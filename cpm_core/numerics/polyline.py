"""Polygonal lines: length, places along them, distance, what they enclose, and the same line with fewer corners."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Sequence

import numpy as np

from cpm_core.numerics.segments import distances_to_segments, nearest_distances, winds_around
from cpm_core.numerics.types import Array, Index, Line, Mask, Position

MOST_HANDLES = 24
"""Corners up to which each of them is a handle; freehand paths have more."""

_TOLERANCE = 0.25
"""Largest distance of a simplified path from the drawn one [px]: less than a pixel of the pointer."""

_HALVINGS = 3
"""How often every second corner of a path may be left out before it is painted."""


def corners_of(path: Array | Sequence[Sequence[float]]) -> Array:
    """Corners of a path as an array, shape (K, D)."""
    return np.asarray(path, float)


def as_line(points: Array) -> Line:
    """Positions of an array as plain numbers."""
    return tuple(map(tuple, points.tolist()))


def owners(counts: Sequence[int] | Index) -> Index:
    """Which of several things each of their parts is of, by how many parts each has."""
    return np.repeat(np.arange(len(counts)), counts)


def lengths_along(path: Array) -> Array:
    """Length along a path, shape (K, D), up to each of its vertices, shape (K,) [px]; 0 at the first."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])


def length(path: Array | Sequence[Position]) -> float:
    """Length along a path [px]."""
    corners = np.asarray(path, float).reshape(len(path), -1)
    return float(np.linalg.norm(corners[1:] - corners[:-1], axis=1).sum())


def places_at(path: Array, lengths: Array) -> Array:
    """Places on a path, shape (K, D), at lengths along it, shape (N,), shape (N, D) [px]."""
    along = lengths_along(path)
    return np.stack([np.interp(lengths, along, axis) for axis in path.T], axis=1)


def middles(path: Array, count: int) -> Array:
    """Midpoints of `count` equal parts of a path, shape (K, D), shape (count, D) [px]."""
    return places_at(path, (np.arange(count) + 0.5) * lengths_along(path)[-1] / count)


def middles_of(paths: Sequence[Array], count: int) -> Array:
    """`middles` of many paths, one or more, shape (P, count, D), at once."""
    counts = [len(path) for path in paths]
    corners, ends = np.concatenate(paths), np.cumsum(counts)
    steps = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    steps[ends[:-1] - 1] = 1.0  # so that no path begins where another one ends
    along = np.concatenate([[0.0], np.cumsum(steps)])
    begin, end = along[ends - counts, None], along[ends - 1, None]
    at = begin + (np.arange(count) + 0.5) / count * (end - begin)
    return np.stack([np.interp(at, along, axis) for axis in corners.T], axis=-1)


def sampled(path: Array, spacing: float) -> Array:
    """Midpoints of equal parts of a path that are at most `spacing` long, shape (N, D) [px].

    Each stands for the same length, so that a mean over them is a mean over the length.
    """
    return middles(path, max(1, int(np.ceil(length(path) / spacing))))


def resampled(path: Array, spacing: float) -> Array:
    """Path, shape (K, D), with vertices at equal distances of at most `spacing` [px] and at least one between its ends.

    Both ends are kept to the bit.
    """
    whole = lengths_along(path)[-1]
    count = max(2, int(np.ceil(whole / spacing)))
    out = places_at(path, np.linspace(0.0, whole, count + 1))
    out[[0, -1]] = path[[0, -1]]
    return out


def distance(path: Array | Sequence[Position], position: Position) -> float:
    """Distance of a position (row, col) from the nearest place on a path of at least one corner [px]."""
    return float(distances(path, np.array([position], float))[0])


def distances(path: Array | Sequence[Position], positions: Array) -> Array:
    """Distances of positions, shape (N, D), from the nearest place on a path of one corner or more, shape (N,)."""
    corners = corners_of(path)
    if len(corners) == 1:
        corners = corners[[0, 0]]
    if corners.shape[1] != 2:
        away = distances_to_segments(np.asarray(positions, float)[:, None], corners[:-1], np.diff(corners, axis=0))
        return away.min(axis=1)
    sides = np.concatenate([corners[:-1], corners[1:]], axis=1)
    return nearest_distances(np.ascontiguousarray(positions, float), sides)


def distances_from_closed(curves: Iterable[Sequence[Position]], positions: Array) -> Array:
    """Distances of positions, shape (N, 2), from the nearest of closed curves, one or more, shape (N,).

    The first corner of a curve is not repeated at its end.
    """
    return np.min([distances((*curve, curve[0]), positions) for curve in curves], axis=0)


def inside(path: Array | Sequence[Position], positions: Array) -> Mask:
    """Which positions, shape (N, 2), lie inside a path that is closed from its last corner to its first, shape (N,)."""
    places = np.ascontiguousarray(positions, float).reshape(-1, 2)
    return winds_around(np.ascontiguousarray(corners_of(path)), places)


def area(path: Array | Sequence[Position]) -> float:
    """Area inside a path whose last corner is joined to its first [px²]."""
    row, col = np.array(path, float).T
    return 0.5 * abs(float(row @ np.roll(col, -1) - col @ np.roll(row, -1)))


def thinned(path: Sequence[Position], tolerance: float = _TOLERANCE) -> Line:
    """Path without the corners that are not needed; both ends stay.

    A freehand path has a corner for every movement of the pointer, but a document should stay small. Of the corners
    between two that are kept, the farthest one is kept as well, until none is off by more than the tolerance (Douglas
    and Peucker 1973). scikit-image has the same function, but takes longer to load than the whole window.
    """
    corners = np.array(path, float)
    kept = {0, len(corners) - 1}
    stretches = [(0, len(corners) - 1)]
    while stretches:
        first, last = stretches.pop()
        off = distances_to_segments(corners[first + 1 : last], corners[first], corners[last] - corners[first])
        if len(off) and off.max() > tolerance:
            farthest = first + 1 + int(off.argmax())
            kept.add(farthest)
            stretches += [(first, farthest), (farthest, last)]
    return as_line(corners[sorted(kept)])


def coarser(paths: Sequence[Array], off: float) -> list[Array]:
    """Leave out corners that lie close to the line between their neighbors; both ends of each path, shape (K, 2), stay.

    Much faster than `thinned`, but it leaves more corners: where possible it leaves out every second corner,
    `_HALVINGS` times. A corner that is left out is at most `off` [px] from the line; in all, a path moves by at most
    `_HALVINGS` times as much.
    """
    if not paths:
        return []
    corners = np.concatenate(paths)
    number = owners([len(path) for path in paths])
    for _ in range(_HALVINGS):
        before, along = corners[1:-1] - corners[:-2], corners[2:] - corners[:-2]
        behind = along - before
        aside = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]
        flat = aside**2 <= off**2 * np.einsum("ij,ij->i", along, along)
        onward = np.einsum("ij,ij->i", before, behind) > 0.0
        left_out = np.zeros(len(corners), bool)
        left_out[1:-1] = flat & onward & (number[2:] == number[:-2])
        left_out[::2] = False  # so that the neighbors stay
        corners, number = corners[~left_out], number[~left_out]
    return np.split(corners, np.flatnonzero(np.diff(number)) + 1)


def stretches(on: Mask, closed: bool = False) -> list[Index]:
    """Indices of consecutive marked vertices; those of a closed path go around its end, to the first one if all are."""
    order = np.arange(len(on))
    if on.all():
        return [np.append(order, order[: int(closed)])] if len(on) else []
    if closed:
        order = np.roll(order, -int(np.argmin(on)))
    pieces = np.split(order, np.flatnonzero(np.diff(on[order])) + 1)
    return [piece for piece in pieces if on[piece[0]]]


def moved(path: Sequence[Position], by: Position) -> Line:
    """Path displaced by so much along each axis."""
    return tuple(tuple(map(operator.add, corner, by)) for corner in path)


def with_handle_at(path: Sequence[Position], corner: Position, to: Position) -> Line:
    """Path with the corner nearest to a position moved to another position."""
    nearest = np.linalg.norm(corners_of(path) - corner, axis=1).argmin()
    return (*path[:nearest], to, *path[nearest + 1 :])
