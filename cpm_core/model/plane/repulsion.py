"""The Coulomb force of eq. (9) in a run in the plane: the sum over near pairs.

Particles farther away than some spacings make no difference: those between screen them, and the force is scaled by the
distance of the nearest two. So pairs up to a reach are summed, in single precision, over a list of the particles in the
cells around one, relative to that cell. `coulomb_force` sums over all.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.model.coverage import cell_of, sort_by_cell
from cpm_core.numerics.jit import compiled, reordered
from cpm_core.numerics.types import Array, Extent, Index, Single


class PlaneCells(NamedTuple):
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


def build_plane_cells(position: Array, shape: Extent, size: float) -> PlaneCells:
    """Sort the particles `position`, shape (N, 2), on an image of this shape into cells of side `size` [px]."""
    rows, cols = (int(n / size) + 1 for n in shape)
    return PlaneCells(size, rows, cols, *_sort_into_plane_cells(position, size, rows, cols))


@compiled
def _sort_into_plane_cells(position: Array, size: float, rows: int, cols: int) -> tuple[Index, Index, Array, Array]:
    """Return where the particles of each cell begin, and all particles in order with coordinates; see `PlaneCells`."""
    cell = np.empty(len(position), np.int64)
    for i in range(len(position)):
        cell[i] = cell_of(position[i, 0], size, rows) * cols + cell_of(position[i, 1], size, cols)
    order, start = sort_by_cell(cell, rows * cols)
    y, x = np.empty(len(order)), np.empty(len(order))
    for k in range(len(order)):
        y[k], x[k] = position[order[k], 0], position[order[k], 1]
    return start, order, y, x


@compiled
def cells_around(cells: PlaneCells, y: float, x: float, distance: float) -> tuple[int, int, int, int]:
    """Return first and last row and column of the cells that contain all within a distance of a position."""
    return (
        cell_of(y - distance, cells.size, cells.rows),
        cell_of(y + distance, cells.size, cells.rows),
        cell_of(x - distance, cells.size, cells.cols),
        cell_of(x + distance, cells.size, cells.cols),
    )


@compiled
def row_of_cells(cells: PlaneCells, row: int, left: int, right: int) -> tuple[int, int]:
    """Return the first sorted particle in a row of cells from column `left` to `right`, and the one behind the last."""
    return cells.start[row * cells.cols + left], cells.start[row * cells.cols + right + 1]


Bits = NDArray[np.int32]
"""Bits of numbers in single precision."""

VECTOR_LANES = 16
"""Lists are filled up to a multiple of it, so that their sums use vector registers to the end."""

LIST_FILLER = 1e6
"""Coordinate that fills up a list [px]; its force is next to nothing, and its cube is still a number."""

MIN_PAIR_SQUARED = 1e-10
"""Squared distance below which two particles are at the same position: a bound instead of a branch keeps the loop on
vector registers, and such a pair adds its vanishing distance, which is nothing."""

_INFINITY_BITS = np.float32(np.inf).view(np.int32)
"""Bits of infinity."""


@compiled
def gather_near(cells: PlaneCells, row: int, col: int, near: Single) -> tuple[int, int]:
    """List the particles in a cell and around it, relative to the corner of the cell.

    Return how many they are, filled up to lanes, and the offset of the particles of the cell from their sorted order.
    """
    origin_y, origin_x = row * cells.size, col * cells.size
    length, own = 0, 0
    top, bottom, left, right = cells_around(cells, origin_y, origin_x, cells.size)
    for r in range(top, bottom + 1):
        first, last = row_of_cells(cells, r, left, right)
        own = length - first if r == row else own
        for k in range(first, last):
            near[0, length] = cells.y[k] - origin_y
            near[1, length] = cells.x[k] - origin_x
            length += 1
    while length % VECTOR_LANES:
        near[0, length] = near[1, length] = LIST_FILLER
        length += 1
    return length, own


@reordered
def pair_sums(near: Single, bits: Bits, length: int, first: int, last: int, reach: np.float32, sums: Array) -> None:
    """Sum eq. (9) over the pairs nearer than a reach, and find the two nearest neighbors, of listed particles.

    Parameters
    ----------
    near : ndarray of float32, shape (3, M)
        Coordinates of the listed particles, of which there are `length`, and room for their squared distances.
    bits : ndarray of int32, shape (M,)
        View of this room: the bits of positive numbers have the order of the numbers, and integers are compared many
        at once.
    first, last : int
        The first particle to sum for, and the one behind the last.
    reach : float
        Distance up to which particles act [px].
    sums : ndarray, shape (last - first, 4)
        Force on each, and squared distances of its two nearest neighbors, other than zero; infinite for none.
    """
    one, nothing, tiny = np.float32(1.0), np.float32(0.0), np.float32(MIN_PAIR_SQUARED)
    for i in range(first, last):
        # from the list: with a difference that is rounded in another way, a particle would act on itself
        y, x, f_y, f_x = near[0, i], near[1, i], nothing, nothing
        for j in range(length):
            d_y, d_x = y - near[0, j], x - near[1, j]
            squared = d_y * d_y + d_x * d_x
            near[2, j] = squared
            bounded = max(squared, tiny)
            weight = one / (bounded * np.sqrt(bounded))
            weight = weight if squared < reach * reach else nothing
            f_y += weight * d_y
            f_x += weight * d_x
        nearest = _INFINITY_BITS
        for j in range(length):
            here = bits[j]
            here = here if here > 0 else _INFINITY_BITS
            nearest = here if here < nearest else nearest
        second, ties = _INFINITY_BITS, 0
        for j in range(length):
            here = bits[j]
            ties += 1 if here == nearest else 0
            here = here if here > nearest else _INFINITY_BITS
            second = here if here < second else second
        bits[0], bits[1] = nearest, nearest if ties > 1 else second
        n = i - first
        sums[n, 0], sums[n, 1], sums[n, 2], sums[n, 3] = f_y, f_x, near[2, 0], near[2, 1]
