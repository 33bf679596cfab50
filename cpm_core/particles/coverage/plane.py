"""The coverage of an image of rows and columns: newly covered cells, and the steps since the last one."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.particles.cell_list import cell_of
from cpm_core.particles.coverage import CELL, REACH, Coverage
from cpm_core.particles.coverage.tiled_steps import NEVER, TILE, TILE_BITS, Steps, TiledSteps

_LOOKED_AT = 200
"""Particles whose tiles are found in the time in which one tile is copied."""


def cover(coverage: Coverage, positions: Array, on_edge: Mask, step: int) -> tuple[Coverage, int]:
    """Mark the cells of particles on edges as covered at a step.

    `positions`, shape (N, 2) [px], are the particles, `on_edge`, shape (N,), is their edge contact. Returns the
    coverage after it, the same one if no cell is new, and the number of newly covered cells.
    """
    found, latest = coverage.found, coverage.latest
    if not len(positions):
        return coverage, 0
    window = found.window(_tiles_at(positions, found))
    fresh = _count_fresh(window.cells, window.first, positions, on_edge, found.shape)
    if not fresh:
        return coverage, 0
    cells = np.empty((fresh, 2), np.int64)
    new = _mark(window.cells, window.first, positions, on_edge, found.shape, step, cells)
    found = found.replaced(window, _tiles_near(cells[:new], 0, found))
    around = _tiles_near(cells[:new], REACH, latest)
    window = latest.window(around)
    _mark_around(window.cells, window.first, cells[:new], latest.shape, step)
    return Coverage(found, latest.replaced(window, around), coverage.size + new), new


def idle_at(coverage: Coverage, positions: Array, step: int, elsewhere: int) -> Index:
    """Steps since cells around each particle were newly covered, shape (N,); `elsewhere` far from all covered cells."""
    latest, idle = coverage.latest, np.empty(len(positions), np.int64)
    if len(positions):
        window = latest.window(_tiles_at(positions, latest))
        _idle_at(window.cells, window.first, positions, latest.shape, step, elsewhere, idle)
    return idle


@compiled
def _tile_of(row: int, col: int, cols: int) -> np.uint64:
    """Number of the tile of a cell, among `cols` of them along a row; without a sign, so that no loop tests it."""
    return np.uint64((row >> TILE_BITS) * ((cols + TILE - 1) >> TILE_BITS) + (col >> TILE_BITS))


@compiled
def _within(row: int, col: int) -> int:
    """Index of a cell in its tile."""
    return ((row & (TILE - 1)) << TILE_BITS) + (col & (TILE - 1))


@compiled
def _choose_at(positions: Array, shape: tuple[int, ...], chosen: Mask) -> None:
    """Choose the tiles in which particles are."""
    for i in range(len(positions)):
        row, col = cell_of(positions[i, 0], CELL, shape[0]), cell_of(positions[i, 1], CELL, shape[1])
        chosen[_tile_of(row, col, shape[1])] = True


@compiled
def _choose_near(cells: Index, reach: int, shape: tuple[int, ...], chosen: Mask) -> None:
    """Choose the tiles that are within reach of cells."""
    for i in range(len(cells)):
        top, bottom = max(cells[i, 0] - reach, 0), min(cells[i, 0] + reach, shape[0] - 1)
        left, right = max(cells[i, 1] - reach, 0), min(cells[i, 1] + reach, shape[1] - 1)
        for row in range(top & -TILE, bottom + 1, TILE):
            for col in range(left & -TILE, right + 1, TILE):
                chosen[_tile_of(row, col, shape[1])] = True


@compiled
def _idle_at(
    latest: Steps, first: Index, positions: Array, shape: tuple[int, ...], step: int, elsewhere: int, idle: Index
) -> None:
    for i in range(len(positions)):
        row, col = cell_of(positions[i, 0], CELL, shape[0]), cell_of(positions[i, 1], CELL, shape[1])
        newest = latest[np.uint64(first[_tile_of(row, col, shape[1])] + _within(row, col))]
        idle[i] = elsewhere if newest == NEVER else step - newest


@compiled
def _count_fresh(found: Steps, first: Index, positions: Array, on_edge: Mask, shape: tuple[int, ...]) -> int:
    """Particles on an edge in cells that are not covered."""
    fresh = 0
    for i in range(len(positions)):
        row, col = cell_of(positions[i, 0], CELL, shape[0]), cell_of(positions[i, 1], CELL, shape[1])
        place = np.uint64(first[_tile_of(row, col, shape[1])] + _within(row, col))
        fresh += on_edge[i] and found[place] == NEVER
    return fresh


@compiled
def _mark(
    found: Steps, first: Index, positions: Array, on_edge: Mask, shape: tuple[int, ...], step: int, cells: Index
) -> int:
    """Mark the cells of particles on an edge as covered, write those that are new, and return how many there are."""
    new = 0
    for i in range(len(positions)):
        row, col = cell_of(positions[i, 0], CELL, shape[0]), cell_of(positions[i, 1], CELL, shape[1])
        place = np.uint64(first[_tile_of(row, col, shape[1])] + _within(row, col))
        if on_edge[i] and found[place] == NEVER:
            found[place] = step
            cells[new, 0], cells[new, 1] = row, col
            new += 1
    return new


@compiled
def _mark_around(latest: Steps, first: Index, cells: Index, shape: tuple[int, ...], step: int) -> None:
    """Mark all cells within reach of newly covered ones."""
    for i in range(len(cells)):
        for row in range(max(cells[i, 0] - REACH, 0), min(cells[i, 0] + REACH, shape[0] - 1) + 1):
            for col in range(max(cells[i, 1] - REACH, 0), min(cells[i, 1] + REACH, shape[1] - 1) + 1):
                latest[np.uint64(first[_tile_of(row, col, shape[1])] + _within(row, col))] = step


def _tiles_at(positions: Array, steps: TiledSteps) -> Index:
    """Numbers of the tiles in which particles are; of all of them where it takes longer to look than to copy."""
    if len(steps.tiles) * _LOOKED_AT < len(positions):
        return np.arange(len(steps.tiles))
    chosen = np.zeros(len(steps.tiles), np.bool_)
    _choose_at(positions, steps.shape, chosen)
    return np.flatnonzero(chosen)


def _tiles_near(cells: Index, reach: int, steps: TiledSteps) -> Index:
    """Numbers of the tiles within reach of cells, shape (K, 2)."""
    chosen = np.zeros(len(steps.tiles), np.bool_)
    _choose_near(cells, reach, steps.shape, chosen)
    return np.flatnonzero(chosen)
