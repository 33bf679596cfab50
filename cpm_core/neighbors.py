"""Which particles are near which: a grid of cells, each with the chain of particles that lie in it.

The chains can be added to, so that a loop that inserts particles sees those it has just inserted.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.kernels import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_FARTHEST_RING = 8
"""Rings of cells that the search for the nearest particles looks at before it calls a particle lonely."""


@compiled
def cell_of(point: Array, size: float, cells: Index) -> int:
    """Index of the cell that a point lies in; points beyond the grid belong to its outermost cells."""
    index = 0
    for k in range(cells.size):
        index = index * cells[k] + min(max(np.int64(point[k] / size + 0.5), 0), cells[k] - 1)
    return index


@compiled
def build_cells(positions: Array, extent: Index, size: float, room: int) -> tuple[Index, Index, Index]:
    """Sort particles into cells.

    Parameters
    ----------
    positions : ndarray, shape (N, D)
        Particles [px].
    extent : ndarray of int64, shape (D,)
        Shape of the image.
    size : float
        Side of a cell [px].
    room : int
        Particles, these among them, that the chains must have room for.

    Returns
    -------
    cells : ndarray of int64, shape (D,)
        Cells along each axis.
    head : ndarray of int64
        First particle of each cell, -1 for none.
    following : ndarray of int64, shape (room,)
        Next particle of the same cell, -1 at the end of the chain.
    """
    dimension = extent.size
    cells = np.empty(dimension, np.int64)
    total = 1
    for k in range(dimension):
        cells[k] = np.int64(extent[k] / size) + 2
        total *= cells[k]
    head = np.full(total, -1, np.int64)
    following = np.full(room, -1, np.int64)
    for i in range(len(positions) - 1, -1, -1):
        cell = cell_of(positions[i], size, cells)
        following[i] = head[cell]
        head[cell] = i
    return cells, head, following


@compiled
def squared_distance(a: Array, b: Array) -> float:
    """Squared distance of two points."""
    total = 0.0
    for k in range(a.size):
        total += (a[k] - b[k]) ** 2
    return total


@compiled
def block(point: Array, size: float, cells: Index, reach: int, out: Index) -> int:
    """Write the indices of the cells within `reach` cells of a point's own into `out` and return how many they are."""
    dimension = cells.size
    low = np.empty(dimension, np.int64)
    width = np.empty(dimension, np.int64)
    total = 1
    for k in range(dimension):
        own = min(max(np.int64(point[k] / size + 0.5), 0), cells[k] - 1)
        low[k] = max(own - reach, 0)
        width[k] = min(own + reach, cells[k] - 1) - low[k] + 1
        total *= width[k]
    for n in range(total):
        rest, index, stride = n, 0, 1
        for k in range(dimension - 1, -1, -1):
            index += (low[k] + rest % width[k]) * stride
            rest //= width[k]
            stride *= cells[k]
        out[n] = index
    return total


@compiled
def crowded(
    point: Array, radius: float, positions: Array, size: float, cells: Index, head: Index, following: Index, near: Index
) -> bool:
    """Whether any particle lies nearer to a point than `radius`, which must not exceed the side of a cell."""
    for n in range(block(point, size, cells, 1, near)):
        j = head[near[n]]
        while j >= 0:
            if squared_distance(point, positions[j]) < radius * radius:
                return True
            j = following[j]
    return False


@compiled
def nearest_spacing(positions: Array, targets: Index, extent: Index, size: float) -> Array:
    """Local spacing of the particles: mean distance of each to its two nearest.

    Parameters
    ----------
    positions : ndarray, shape (N, D)
        Particles [px].
    targets : ndarray of int64, shape (M,)
        Indices of the particles whose spacing is wanted.
    extent : ndarray of int64, shape (D,)
        Shape of the image.
    size : float
        Side of a cell of the search [px].

    Returns
    -------
    ndarray, shape (M,)
        Mean of the two least distances [px]; what lies beyond eight cells counts as eight cells away.
    """
    count = len(positions)
    cells, head, following = build_cells(positions, extent, size, count)
    near = np.empty((2 * _FARTHEST_RING + 1) ** cells.size, np.int64)
    spacing = np.empty(targets.size)
    farthest = (_FARTHEST_RING * size) ** 2
    for t in range(targets.size):
        i = targets[t]
        reach = 1
        while True:
            first, second = farthest, farthest
            for n in range(block(positions[i], size, cells, reach, near)):
                j = head[near[n]]
                while j >= 0:
                    if j != i:
                        squared = squared_distance(positions[i], positions[j])
                        if squared < first:
                            first, second = squared, first
                        elif squared < second:
                            second = squared
                    j = following[j]
            # Every particle nearer than (reach - 1/2) cells has been seen, wherever in its own cell this one lies.
            if second <= ((reach - 0.5) * size) ** 2 or reach == _FARTHEST_RING:
                break
            reach = min(2 * reach, _FARTHEST_RING)
        spacing[t] = 0.5 * (np.sqrt(first) + np.sqrt(second))
    return spacing
