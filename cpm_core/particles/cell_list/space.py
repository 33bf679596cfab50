"""Particles of space sorted into cubic cells."""

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
    start : ndarray of int64, shape (planes rows cols + 1,)
        Where the particles of each cell begin in the sorted order.
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
    order: Index
    z: Array
    y: Array
    x: Array


@compiled
def build_cells(position: Array, shape: Vector, size: float) -> Cells:
    """Sort the particles `position`, shape (N, 3), in a volume of this size into cells of side `size` [px]."""
    count = len(position)
    planes, rows, cols = int(shape[0] / size) + 1, int(shape[1] / size) + 1, int(shape[2] / size) + 1
    start = np.zeros(planes * rows * cols + 1, np.int64)
    own = np.empty(count, np.int64)
    for i in range(count):
        plane, row = cell_of(position[i, 0], size, planes), cell_of(position[i, 1], size, rows)
        own[i] = (plane * rows + row) * cols + cell_of(position[i, 2], size, cols)
        start[own[i] + 1] += 1
    for c in range(planes * rows * cols):
        start[c + 1] += start[c]
    order, z, y, x = np.empty(count, np.int64), np.empty(count), np.empty(count), np.empty(count)
    cursor = start[:-1].copy()
    for i in range(count):
        k = cursor[own[i]]
        cursor[own[i]] += 1
        order[k], z[k], y[k], x[k] = i, position[i, 0], position[i, 1], position[i, 2]
    return Cells(size, planes, rows, cols, start, order, z, y, x)


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
    first = (plane * cells.rows + row) * cells.cols
    return cells.start[first + left], cells.start[first + right + 1]
