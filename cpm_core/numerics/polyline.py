"""Paths that a hand has drawn: their length, how far off a position lies, and the same path with fewer corners."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Array, Position

MOST_HANDLES = 24
"""Corners up to which each of them is a handle; freehand paths have more."""

_TOLERANCE = 0.25
"""Farthest that a path may be led away from where the hand went [px]: less than the pointer's own pixel."""

_HALVINGS = 3
"""How often every second corner of a path may be left out for drawing it."""


def length(path: Sequence[Position]) -> float:
    """Length along a path [px]."""
    return sum(math.dist(begin, end) for begin, end in pairwise(path))


def distance(path: Sequence[Position], position: Position) -> float:
    """Distance of a position from the nearest place on a path [px].

    Parameters
    ----------
    path : sequence of tuple of float
        At least one corner (row, col) [px].
    position : tuple of float
        (row, col) [px].
    """
    corners = np.array(path, dtype=float)
    if len(corners) == 1:
        return math.dist(path[0], position)
    return float(_off(np.array(position), corners[:-1], corners[1:]).min())


def distances(path: Sequence[Position], positions: Array) -> Array:
    """Distances of positions, shape (N, 2), from the nearest place on a path, shape (N,) [px]."""
    corners = np.array(path, dtype=float)
    nearest = np.hypot(*(positions - corners[0]).T)
    for begin, end in pairwise(corners):
        np.minimum(nearest, _off(positions, begin[None], end[None]), out=nearest)
    return np.asarray(nearest)


def inside(path: Sequence[Position], positions: Array) -> NDArray[np.bool_]:
    """Which positions, shape (N, 2), a path winds around whose last corner is joined to its first, shape (N,)."""
    row, col = np.asarray(positions, dtype=float).reshape(-1, 2).T
    winding = np.zeros(len(row), np.int64)
    for (row_0, col_0), (row_1, col_1) in pairwise((*path, path[0])):
        side = (row_1 - row_0) * (col - col_0) - (row - row_0) * (col_1 - col_0)
        winding += (row_0 <= row) & (row < row_1) & (side > 0.0)
        winding -= (row_1 <= row) & (row < row_0) & (side < 0.0)
    return np.asarray(winding != 0)


def area(path: Sequence[Position]) -> float:
    """Area inside a path whose last corner is joined to its first [px²]."""
    row, col = np.array(path, dtype=float).T
    return 0.5 * abs(float(row @ np.roll(col, -1) - col @ np.roll(row, -1)))


def thinned(path: Sequence[Position]) -> tuple[Position, ...]:
    """The same path without the corners that it can do without; both ends stay.

    A freehand path has a corner for every movement of the pointer; a document is to stay small. Of the corners between
    two that are kept, the one farthest off is kept as well, until none is off by more than the tolerance (Douglas and
    Peucker 1973). scikit-image has the same, but takes longer to load than all of the window.
    """
    corners = np.array(path, dtype=float)
    kept = {0, len(corners) - 1}
    stretches = [(0, len(corners) - 1)]
    while stretches:
        first, last = stretches.pop()
        off = _off(corners[first + 1 : last], corners[[first]], corners[[last]])
        if len(off) and off.max() > _TOLERANCE:
            farthest = first + 1 + int(off.argmax())
            kept.add(farthest)
            stretches += [(first, farthest), (farthest, last)]
    return tuple((float(row), float(col)) for row, col in corners[sorted(kept)])


def coarser(paths: Sequence[Array], off: float) -> list[Array]:
    """Leave out corners that lie next to the line between their neighbours; the ends of each path stay.

    Much faster than to thin them, though it leaves more: where it can, it leaves out every second corner, and that
    `_HALVINGS` times.

    Parameters
    ----------
    paths : sequence of ndarray, shape (K, 2)
        Paths with at least one corner each.
    off : float
        How far off a corner may lie that is left out; in all, a path is led away by `_HALVINGS` times as much at most.
    """
    if not paths:
        return []
    corners = np.concatenate(paths)
    number = np.repeat(np.arange(len(paths)), [len(path) for path in paths])
    for _ in range(_HALVINGS):
        before, along = corners[1:-1] - corners[:-2], corners[2:] - corners[:-2]
        behind = along - before
        aside = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]
        flat = aside**2 <= off**2 * np.einsum("ij,ij->i", along, along)
        onward = np.einsum("ij,ij->i", before, behind) > 0.0
        left_out = np.zeros(len(corners), np.bool_)
        left_out[1:-1] = flat & onward & (number[2:] == number[:-2])
        left_out[::2] = False  # so that the neighbours stay
        corners, number = corners[~left_out], number[~left_out]
    return np.split(corners, np.flatnonzero(np.diff(number)) + 1)


def moved(path: Sequence[Position], by: Position) -> tuple[Position, ...]:
    """The same path displaced by (rows, cols)."""
    return tuple((row + by[0], col + by[1]) for row, col in path)


def with_handle_at(path: Sequence[Position], corner: Position, to: Position) -> tuple[Position, ...]:
    """The same path with the corner nearest to a position led to another one."""
    nearest = min(range(len(path)), key=lambda index: math.dist(path[index], corner))
    return tuple(to if index == nearest else position for index, position in enumerate(path))


def _off(positions: Array, begins: Array, ends: Array) -> Array:
    """Distances of positions from segments, where one of them may be many of the other."""
    along, offset = ends - begins, positions - begins
    square = np.einsum("ij,ij->i", along, along)
    share = np.einsum("ij,ij->i", offset, np.broadcast_to(along, offset.shape)) / np.where(square > 0, square, 1.0)
    return np.asarray(np.hypot(*(offset - np.clip(share, 0.0, 1.0)[:, None] * along).T))
