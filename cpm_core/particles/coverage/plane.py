"""The coverage of an image of rows and columns: newly covered cells, and the steps since the last one."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.particles.cell_list import cell_of
from cpm_core.particles.coverage import CELL, NEVER, REACH, Coverage, Steps


def cover(coverage: Coverage, positions: Array, on_edge: Mask, step: int) -> tuple[Coverage, int]:
    """Mark the cells of particles on edges as covered at a step.

    `positions`, shape (N, 2) [px], are the particles, `on_edge`, shape (N,), is their edge contact. Returns the
    coverage after it, the same one if no cell is new, and the number of newly covered cells.
    """
    if not _count_fresh(coverage.found, positions, on_edge):
        return coverage, 0
    after = Coverage(coverage.found.copy(), coverage.latest.copy())
    return after, int(_mark(after, positions, on_edge, step))


def idle_at(coverage: Coverage, positions: Array, step: int, elsewhere: int) -> Index:
    """Steps since cells around each particle were newly covered, shape (N,); see `idle_steps`."""
    idle = np.empty(len(positions), np.int64)
    _idle_at(coverage.latest, positions, step, elsewhere, idle)
    return idle


@compiled
def _idle_at(latest: Steps, position: Array, step: int, elsewhere: int, idle: Index) -> None:
    for i in range(len(position)):
        idle[i] = idle_steps(latest, position[i, 0], position[i, 1], step, elsewhere)


@compiled
def idle_steps(latest: Steps, y: float, x: float, step: int, elsewhere: int) -> int:
    """Steps since cells around a position [px] were newly covered; `elsewhere` far from all covered cells."""
    newest = latest[cell_of(y, CELL, latest.shape[0]), cell_of(x, CELL, latest.shape[1])]
    return elsewhere if newest == NEVER else step - newest


@compiled
def _count_fresh(found: Steps, position: Array, on_edge: Mask) -> int:
    """Particles on an edge in cells that are not covered."""
    fresh = 0
    for i in range(len(position)):
        row, col = cell_of(position[i, 0], CELL, found.shape[0]), cell_of(position[i, 1], CELL, found.shape[1])
        fresh += on_edge[i] and found[row, col] == NEVER
    return fresh


@compiled
def _mark(coverage: Coverage, position: Array, on_edge: Mask, step: int) -> int:
    """Mark the covered cells in place and return how many are new."""
    found, latest = coverage.found, coverage.latest
    new = 0
    for i in range(len(position)):
        row, col = cell_of(position[i, 0], CELL, found.shape[0]), cell_of(position[i, 1], CELL, found.shape[1])
        if on_edge[i] and found[row, col] == NEVER:
            found[row, col] = step
            new += 1
            for r in range(max(row - REACH, 0), min(row + REACH + 1, found.shape[0])):
                for c in range(max(col - REACH, 0), min(col + REACH + 1, found.shape[1])):
                    latest[r, c] = step
    return new
