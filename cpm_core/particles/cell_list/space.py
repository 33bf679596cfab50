"""Particles of space sorted into cubic cells.

Surfaces fill few of the cells of a large volume. The list has an entry for each row of cells along the last axis and
not for each cell; within a row the particles are sorted by their cells, and those of some cells are found by bisection.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index
from cpm_core.numerics.vectors import Vector
from cpm_core.particles.cell_list import cell_of


class Cells(NamedTuple):
    """Particles sorted into cubic cells; a plain tuple for the compiled loops.

    The particles of a row of cells along the last axis are contiguous.

    Attributes
    ----------
    size : float
        Side of a cell [px].
    planes, rows, cols : int
        Cells along the axes; positions beyond the grid belong to its outermost cells.
    start : ndarray of int64, shape (planes rows + 1,)
        Where the particles of each row of cells begin in the sorted order.
    col : ndarray of int64, shape (N,)
        Column of the cell of each of the sorted particles.
    order : ndarray of int64, shape (N,)
        Index of each of the sorted particles.
    z, y, x : ndarray, shape (N,)
        Positions of the sorted particles [px].
    """

    size: float
    planes: int
    rows: int
    cols: int
    start: Index
    col: Index
    order: Index
    z: Array
    y: Array
    x: Array


def build_cells(position: Array, shape: Vector, size: float) -> Cells:
    """Sort the particles `position`, shape (N, 3), in a volume of this size into cells of side `size` [px]."""
    return Cells(size, *_sorted(position, shape, size))


@compiled
def _sorted(
    position: Array, shape: Vector, size: float
) -> tuple[int, int, int, Index, Index, Index, Array, Array, Array]:
    """All fields of cells but the first."""
    count = len(position)
    planes, rows, cols = int(shape[0] / size) + 1, int(shape[1] / size) + 1, int(shape[2] / size) + 1
    row_of, col_of, by_col = np.empty(count, np.int64), np.empty(count, np.int64), np.empty(count, np.int64)
    start, first = np.zeros(planes * rows + 1, np.int64), np.zeros(cols + 1, np.int64)
    for i in range(count):
        plane, row = cell_of(position[i, 0], size, planes), cell_of(position[i, 1], size, rows)
        row_of[i], col_of[i] = plane * rows + row, cell_of(position[i, 2], size, cols)
        start[row_of[i] + 1] += 1
        first[col_of[i] + 1] += 1
    _add_up(start)
    _add_up(first)
    for i in range(count):
        by_col[first[col_of[i]]] = i
        first[col_of[i]] += 1
    order, col = np.empty(count, np.int64), np.empty(count, np.int64)
    z, y, x = np.empty(count), np.empty(count), np.empty(count)
    cursor = start[:-1].copy()
    for n in range(count):
        i = by_col[n]
        k = cursor[row_of[i]]
        cursor[row_of[i]] += 1
        order[k], col[k] = i, col_of[i]
        z[k], y[k], x[k] = position[i, 0], position[i, 1], position[i, 2]
    return planes, rows, cols, start, col, order, z, y, x


@compiled
def _add_up(counts: Index) -> None:
    """Turn the numbers of things into where they begin, in place."""
    for k in range(1, len(counts)):
        counts[k] += counts[k - 1]


@compiled
def cells_around(cells: Cells, z: float, y: float, x: float, distance: float) -> tuple[int, int, int, int, int, int]:
    """First and last plane, row and column of the cells that contain all nearer to a position than a distance."""
    return (
        cell_of(z - distance, cells.size, cells.planes),
        cell_of(z + distance, cells.size, cells.planes),
        cell_of(y - distance, cells.size, cells.rows),
        cell_of(y + distance, cells.size, cells.rows),
        cell_of(x - distance, cells.size, cells.cols),
        cell_of(x + distance, cells.size, cells.cols),
    )


@compiled
def row_of_cells(cells: Cells, plane: int, row: int, left: int, right: int) -> tuple[int, int]:
    """First of the sorted particles in a row of cells from column `left` to `right`, and the one behind the last."""
    line = plane * cells.rows + row
    first, last = cells.start[line], cells.start[line + 1]
    return _first_from(cells.col, left, first, last), _first_from(cells.col, right + 1, first, last)


@compiled
def _first_from(col: Index, wanted: int, low: int, high: int) -> int:
    """First of some entries in ascending order that is not below a wanted one; `high` if all are."""
    while low < high:
        middle = (low + high) // 2
        if col[middle] < wanted:
            low = middle + 1
        else:
            high = middle
    return low
