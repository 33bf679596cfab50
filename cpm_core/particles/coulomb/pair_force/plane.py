"""Pairs of particles of the plane."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled, reordered
from cpm_core.numerics.types import Single
from cpm_core.particles.cell_list.plane import Cells, cells_around, row_of_cells
from cpm_core.particles.coulomb.pair_force import FILLER, LANES, NEAREST, SAME_SPOT


@compiled
def gather(cells: Cells, row: int, col: int, near_y: Single, near_x: Single) -> tuple[int, int]:
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
            near_y[length] = cells.y[k] - origin_y
            near_x[length] = cells.x[k] - origin_x
            length += 1
    while length % LANES:
        near_y[length] = near_x[length] = FILLER
        length += 1
    return length, own


@reordered
def pair_sum(
    near_y: Single,
    near_x: Single,
    squares: Single,
    length: int,
    y: np.float32,
    x: np.float32,
    reach: np.float32,
    softening: Single,
) -> tuple[float, float]:
    """Sum what the mesh leaves out of eq. (9), in single precision, and keep the squared distances."""
    one, nothing, tiny = np.float32(1.0), np.float32(0.0), np.float32(SAME_SPOT)
    f_y, f_x, a, b, c = nothing, nothing, softening[0], softening[1], softening[2]
    for j in range(length):
        d_y, d_x = y - near_y[j], x - near_x[j]
        squared = d_y * d_y + d_x * d_x
        squares[j] = squared
        bounded = max(squared, tiny)
        weight = one / (bounded * np.sqrt(bounded)) - (a + squared * (b + squared * c))
        weight = weight if squared < reach * reach else nothing
        f_y += weight * d_y
        f_x += weight * d_x
    return float(f_y), float(f_x)


@compiled
def two_nearest_of_many(cells: Cells, y: float, x: float, farthest: float) -> tuple[float, float]:
    """Squared distances of the two nearest particles, of those up to a distance at least; infinite for none."""
    first, second = np.inf, np.inf
    top, bottom, left, right = cells_around(cells, y, x, farthest)
    for row in range(top, bottom + 1):
        start, end = row_of_cells(cells, row, left, right)
        for k in range(start, end):
            squared = (cells.y[k] - y) ** 2 + (cells.x[k] - x) ** 2
            if 0.0 < squared < first:
                first, second = squared, first
            elif 0.0 < squared < second:
                second = squared
    return first, second


@compiled
def pair_energy(cells: Cells, reach: float) -> float:
    """Sum of ``1/r - 1/R`` over the pairs nearer than R."""
    total = 0.0
    for k in range(len(cells.y)):
        y, x = cells.y[k], cells.x[k]
        top, bottom, left, right = cells_around(cells, y, x, reach)
        for row in range(top, bottom + 1):
            first, last = row_of_cells(cells, row, left, right)
            for j in range(max(first, k + 1), last):
                squared = (cells.y[j] - y) ** 2 + (cells.x[j] - x) ** 2
                if squared < reach**2:
                    total += 1.0 / max(np.sqrt(squared), NEAREST) - 1.0 / reach
    return total
