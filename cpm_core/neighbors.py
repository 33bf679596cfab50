"""Which particles are near which: a grid of cells, each with the chain of particles that lie in it.

The chains can be added to, so that a loop that inserts particles sees those it has just inserted.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.kernels import compiled

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_FARTHEST_RING = 8
"""Rings of cells that the search for the nearest particles looks at before it calls a particle lonely."""


class Cells(NamedTuple):
    """Particles sorted into cells; a plain tuple for the compiled loops.

    Attributes
    ----------
    position : ndarray, shape (room, D)
        Particles [px]; those not yet sorted in do not count.
    size : float
        Side of a cell [px].
    along : ndarray of int64, shape (D,)
        Cells along each axis.
    head : ndarray of int64
        First particle of each cell, -1 for none.
    following : ndarray of int64, shape (room,)
        Next particle of the same cell, -1 at the end of the chain.
    around : ndarray of int64, shape (3^D,)
        Scratch for the indices of a cell and those it touches.
    """

    position: Array
    size: float
    along: Index
    head: Index
    following: Index
    around: Index


@compiled
def build_cells(position: Array, count: int, extent: Index, size: float) -> Cells:
    """Sort the first `count` of the particles `position`, shape (room, D), on an image of shape `extent` into cells."""
    dimension = extent.size
    along = np.empty(dimension, np.int64)
    total = 1
    for k in range(dimension):
        along[k] = np.int64(extent[k] / size) + 2
        total *= along[k]
    head = np.full(total, -1, np.int64)
    following = np.full(len(position), -1, np.int64)
    cells = Cells(position, size, along, head, following, np.empty(3**dimension, np.int64))
    for i in range(count - 1, -1, -1):
        sort_in(cells, i)
    return cells


@compiled
def own_cell(cells: Cells, point: Array, k: int) -> int:
    """Cell that a point lies in, along one axis; points beyond the grid belong to its outermost cells."""
    return int(min(max(np.int64(point[k] / cells.size + 0.5), 0), cells.along[k] - 1))


@compiled
def sort_in(cells: Cells, i: int) -> None:
    """Add particle `i` to the chain of its cell."""
    index = 0
    for k in range(cells.along.size):
        index = index * cells.along[k] + own_cell(cells, cells.position[i], k)
    cells.following[i] = cells.head[index]
    cells.head[index] = i


@compiled
def squared_distance(a: Array, b: Array) -> float:
    """Squared distance of two points."""
    total = 0.0
    for k in range(a.size):
        total += (a[k] - b[k]) ** 2
    return total


@compiled
def block(cells: Cells, point: Array, reach: int, out: Index) -> int:
    """Write the indices of the cells within `reach` cells of a point's own into `out` and return how many they are."""
    dimension = cells.along.size
    low = np.empty(dimension, np.int64)
    width = np.empty(dimension, np.int64)
    total = 1
    for k in range(dimension):
        own = own_cell(cells, point, k)
        low[k] = max(own - reach, 0)
        width[k] = min(own + reach, cells.along[k] - 1) - low[k] + 1
        total *= width[k]
    for n in range(total):
        rest, index, stride = n, 0, 1
        for k in range(dimension - 1, -1, -1):
            index += (low[k] + rest % width[k]) * stride
            rest //= width[k]
            stride *= cells.along[k]
        out[n] = index
    return total


@compiled
def count_near(cells: Cells, point: Array, radius: float) -> int:
    """Particles nearer to a point than `radius`, which must not exceed the side of a cell."""
    count = 0
    for n in range(block(cells, point, 1, cells.around)):
        j = cells.head[cells.around[n]]
        while j >= 0:
            if squared_distance(point, cells.position[j]) < radius * radius:
                count += 1
            j = cells.following[j]
    return count


@compiled
def nearest_spacing(position: Array, targets: Index, extent: Index, size: float) -> Array:
    """Local spacing of the particles: mean distance of each to its two nearest.

    Parameters
    ----------
    position : ndarray, shape (N, D)
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
    cells = build_cells(position, len(position), extent, size)
    near = np.empty((2 * _FARTHEST_RING + 1) ** extent.size, np.int64)
    spacing = np.empty(targets.size)
    farthest = (_FARTHEST_RING * size) ** 2
    for t in range(targets.size):
        i = targets[t]
        reach = 1
        while True:
            first, second = farthest, farthest
            for n in range(block(cells, position[i], reach, near)):
                j = cells.head[near[n]]
                while j >= 0:
                    if j != i:
                        squared = squared_distance(position[i], position[j])
                        if squared < first:
                            first, second = squared, first
                        elif squared < second:
                            second = squared
                    j = cells.following[j]
            # Every particle nearer than (reach - 1/2) cells has been seen, wherever in its own cell this one lies.
            if second <= ((reach - 0.5) * size) ** 2 or reach == _FARTHEST_RING:
                break
            reach = min(2 * reach, _FARTHEST_RING)
        spacing[t] = 0.5 * (np.sqrt(first) + np.sqrt(second))
    return spacing
