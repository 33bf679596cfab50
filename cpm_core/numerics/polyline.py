"""Polygonal lines: length, points along them, distance, enclosed area, and simplification."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.segments import distances_to_segments, winds_around
from cpm_core.numerics.types import Array, Index, Line, Mask, Position

_Kind = TypeVar("_Kind", bound=np.generic)

MAX_CORNER_HANDLES = 24
"""Largest number of corners with a handle each; freehand paths have more corners."""

_SIMPLIFY_TOLERANCE = 0.25
"""Largest distance of a simplified path from the drawn one [px]: less than a pixel of the pointer."""

_HALVING_ROUNDS = 3
"""Number of times that every second corner of a path may be dropped before it is painted."""


def corners_of(path: Array | Sequence[Sequence[float]]) -> Array:
    """Return corners of a path as an array, shape (K, D)."""
    return np.asarray(path, float)


def as_line(points: Array) -> Line:
    """Return positions of an array as plain numbers."""
    return tuple(map(tuple, points.tolist()))


def repeat_indices(counts: Sequence[int] | Index) -> Index:
    """Return the index of the owner of each part, shape (N,); `counts` is how many parts each owner has."""
    return np.repeat(np.arange(len(counts)), counts)


def step_lengths(path: Array) -> Array:
    """Measure the length of each stretch of a path, shape (K, D), from vertex to vertex, shape (K - 1,)."""
    return np.linalg.norm(np.diff(path, axis=0), axis=1)


def pair_neighbors(path: NDArray[_Kind]) -> NDArray[_Kind]:
    """Pair each vertex of a path, or what is known of it, shape (K, ...), with the next one, shape (K - 1, 2, ...)."""
    return np.stack([path[:-1], path[1:]], axis=1)


def lengths_along(path: Array) -> Array:
    """Return the length along a path, shape (K, D), up to each of its vertices, shape (K,) [px]; 0 at the first."""
    return np.concatenate([[0.0], np.cumsum(step_lengths(path))])


def path_length(path: Array | Sequence[Position]) -> float:
    """Return the length of a path, shape (K, D) [px]."""
    corners = np.asarray(path, float).reshape(len(path), -1)
    return float(np.linalg.norm(corners[1:] - corners[:-1], axis=1).sum())


def points_at_lengths(path: Array, lengths: Array) -> Array:
    """Return the points, shape (N, D), that lie at lengths, shape (N,), along a path, shape (K, D) [px]."""
    along = lengths_along(path)
    return np.stack([np.interp(lengths, along, axis) for axis in path.T], axis=1)


def path_midpoints(path: Array, count: int) -> Array:
    """Return the midpoints, shape (count, D), of `count` equal parts of a path, shape (K, D) [px]."""
    return points_at_lengths(path, (np.arange(count) + 0.5) * lengths_along(path)[-1] / count)


def midpoints_of_paths(paths: Sequence[Array], count: int) -> Array:
    """Return `path_midpoints` of one or more paths, shape (P, count, D), at once."""
    counts = [len(path) for path in paths]
    corners, ends = np.concatenate(paths), np.cumsum(counts)
    steps = step_lengths(corners)
    steps[ends[:-1] - 1] = 1.0  # so that no path begins where another one ends
    along = np.concatenate([[0.0], np.cumsum(steps)])
    begin, end = along[ends - counts, None], along[ends - 1, None]
    at = begin + (np.arange(count) + 0.5) / count * (end - begin)
    return np.stack([np.interp(at, along, axis) for axis in corners.T], axis=-1)


def sample_path(path: Array, spacing: float) -> Array:
    """Return the midpoints of equal parts of a path that are at most `spacing` long, shape (N, D) [px].

    Each represents the same length, so that a mean over them is a mean over the length.
    """
    return path_midpoints(path, max(1, int(np.ceil(path_length(path) / spacing))))


def resample_path(path: Array, spacing: float) -> Array:
    """Return a path, shape (K, D), with vertices at equal distances of at most `spacing` [px], one or more inside.

    Both ends are kept to the bit.
    """
    whole = lengths_along(path)[-1]
    count = max(2, int(np.ceil(whole / spacing)))
    out = points_at_lengths(path, np.linspace(0.0, whole, count + 1))
    out[[0, -1]] = path[[0, -1]]
    return out


def project_point(path: Array, place: Position) -> float:
    """Return the length along a path, shape (K, 2), up to its point nearest to a place [px]."""
    import shapely  # noqa: PLC0415 - takes long to load

    return float(shapely.line_locate_point(shapely.LineString(path), shapely.Point(place)))


def distance_to_path(path: Array | Sequence[Position], position: Position) -> float:
    """Return the distance of a position (row, col) from a path, shape (K, 2), of at least one corner [px]."""
    return float(distances_to_path(path, np.array([position], float))[0])


def distances_to_path(path: Array | Sequence[Position], positions: Array) -> Array:
    """Return distances, shape (N,), of positions, shape (N, D), from a path of one corner or more, shape (K, D)."""
    corners = corners_of(path)
    if corners.shape[1] != 2:
        begin, end = (corners[:-1], corners[1:]) if len(corners) > 1 else (corners, corners)
        return distances_to_segments(np.asarray(positions, float)[:, None], begin, end - begin).min(axis=1)
    import shapely  # noqa: PLC0415 - takes long to load

    line = shapely.LineString(corners) if len(corners) > 1 else shapely.Point(corners[0])
    return np.asarray(shapely.distance(line, shapely.points(positions)))


def distances_to_closed_paths(curves: Iterable[Sequence[Position]], positions: Array) -> Array:
    """Return the distances, shape (N,), of positions, shape (N, 2), from the nearest of one or more closed curves.

    The first corner of a curve is not repeated at its end.
    """
    return np.min([distances_to_path((*curve, curve[0]), positions) for curve in curves], axis=0)


def points_inside(path: Array | Sequence[Position], positions: Array) -> Mask:
    """Return a mask, shape (N,), of the positions, shape (N, 2), inside a path, closed from its last corner."""
    places = np.ascontiguousarray(positions, float).reshape(-1, 2)
    return winds_around(np.ascontiguousarray(corners_of(path)), places)


def find_holes(curves: Sequence[Array | Sequence[Position]]) -> list[bool]:
    """Tell which curves, each of shape (K, 2), bound holes of one area: those that an odd number of others encloses."""
    return [
        sum(bool(points_inside(other, np.array(curve[:1]))[0]) for other in curves if other is not curve) % 2 == 1
        for curve in curves
    ]


def enclosed_area(path: Array | Sequence[Position]) -> float:
    """Return the area enclosed by a path, shape (K, 2), closed from its last corner to its first [px²]."""
    row, col = np.array(path, float).T
    return 0.5 * abs(float(row @ np.roll(col, -1) - col @ np.roll(row, -1)))


def simplify_path(path: Sequence[Position], tolerance: float = _SIMPLIFY_TOLERANCE) -> Line:
    """Remove the corners of a path, shape (K, 2), that are not needed; both ends stay.

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


def drop_flat_corners(paths: Sequence[Array], off: float) -> list[Array]:
    """Drop corners that lie close to the line between their neighbors; both ends of each path, shape (K, 2), stay.

    Much faster than `simplify_path`, but it leaves more corners: it drops every second corner where possible,
    `_HALVING_ROUNDS` times. A dropped corner is at most `off` [px] from the line; in total, a path moves by at most
    `_HALVING_ROUNDS` times as much.
    """
    if not paths:
        return []
    corners = np.concatenate(paths)
    number = repeat_indices([len(path) for path in paths])
    for _ in range(_HALVING_ROUNDS):
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


def find_marked_runs(on: Mask, closed: bool = False) -> list[Index]:
    """Return the index runs of marked vertices, `on` of shape (K,); runs of a closed path continue past its end."""
    order = np.arange(len(on))
    if on.all():
        return [np.append(order, order[: int(closed)])] if len(on) else []
    if closed:
        order = np.roll(order, -int(np.argmin(on)))
    pieces = np.split(order, np.flatnonzero(np.diff(on[order])) + 1)
    return [piece for piece in pieces if on[piece[0]]]


def translate_path(path: Sequence[Position], by: Position) -> Line:
    """Translate a path by an offset along each axis [px]."""
    return tuple(tuple(map(operator.add, corner, by)) for corner in path)


def move_corner(path: Sequence[Position], corner: Position, to: Position) -> Line:
    """Return a path with the corner nearest to a position moved to another position."""
    nearest = np.linalg.norm(corners_of(path) - corner, axis=1).argmin()
    return (*path[:nearest], to, *path[nearest + 1 :])
