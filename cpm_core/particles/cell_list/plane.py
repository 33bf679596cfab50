"""Particles of the plane sorted into square cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index
from cpm_core.particles.cell_list import cell_of


class Cells(NamedTuple):
    """Particles sorted into square cells; a plain tuple for the compiled loops.

    All particles nearer to a position than the side of a cell lie in its cell and the eight around it, and the
    particles of a row of cells are contiguous.

    Attributes
    ----------
    size : float
        Side of a cell [px].
    rows, cols : int
        Cells along the axes; positions beyond the grid belong to its outermost cells.
    start : ndarray of int64, shape (rows cols + 1,)
        Where the particles of each cell begin in the sorted order.
    order : ndarray of int64, shape (N,)
        Index of each of the sorted particles.
    y, x : ndarray, shape (N,)
        Positions of the sorted particles [px].
    """

    size: float
    rows: int
    cols: int
    start: Index
    order: Index
    y: Array
    x: Array


def build_cells(position: Array, shape: tuple[int, ...], size: float) -> Cells:
    """Sort the particles `position`, shape (N, 2), on an image of this shape into cells of side `size` [px]."""
    return Cells(size, *_sorted(position, shape, size))


@compiled
def _sorted(position: Array, shape: tuple[int, ...], size: float) -> tuple[int, int, Index, Index, Array, Array]:
    """All fields of cells but the first."""
    count = len(position)
    rows, cols = int(shape[0] / size) + 1, int(shape[1] / size) + 1
    start = np.zeros(rows * cols + 1, np.int64)
    own = np.empty(count, np.int64)
    for i in range(count):
        own[i] = cell_of(position[i, 0], size, rows) * cols + cell_of(position[i, 1], size, cols)
        start[own[i] + 1] += 1
    for c in range(rows * cols):
        start[c + 1] += start[c]
    order, y, x = np.empty(count, np.int64), np.empty(count), np.empty(count)
    cursor = start[:-1].copy()
    for i in range(count):
        k = cursor[own[i]]
        cursor[own[i]] += 1
        order[k], y[k], x[k] = i, position[i, 0], position[i, 1]
    return rows, cols, start, order, y, x


@compiled
def cells_around(cells: Cells, y: float, x: float, distance: float) -> tuple[int, int, int, int]:
    """First and last row, first and last column of the cells that contain all nearer to a position than a distance."""
    return (
        cell_of(y - distance, cells.size, cells.rows),
        cell_of(y + distance, cells.size, cells.rows),
        cell_of(x - distance, cells.size, cells.cols),
        cell_of(x + distance, cells.size, cells.cols),
    )


@compiled
def row_of_cells(cells: Cells, row: int, left: int, right: int) -> tuple[int, int]:
    """First of the sorted particles in a row of cells from column `left` to `right`, and the one behind the last."""
    return cells.start[row * cells.cols + left], cells.start[row * cells.cols + right + 1]
