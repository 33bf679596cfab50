"""Coverage: where and when particles have first been on an edge.

The number of particles does not measure progress: particles gather and are deleted again. The number of covered cells
of the image does: it can only rise and is bounded. Particles without newly covered cells around them for some steps are
brought to rest, each neighborhood separately, so that every run ends and a distant front does not keep the others
moving.

In a volume a cell counts once for each side that a surface in it faces, so that the second wall of a thin object is new
coverage. The cells found are kept as a sorted list: surfaces fill few of them.
"""

from __future__ import annotations

from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Extent, Index, Mask


@compiled
def cell_of(place: float, size: float, along: int) -> int:
    """Return the cell of side `size` [px] of a coordinate, among `along` cells; those beyond belong to the ends."""
    return int(min(max(int((place + 0.5) / size), 0), along - 1))


@compiled
def sort_by_cell(cells: Index, order: Index, start: Index) -> None:
    """Sort items stably by their cells, shape (N,).

    The order is written, and where each cell begins, and the last ends, over the zeros of `start`.
    """
    for i in range(len(cells)):
        start[cells[i]] += 1
    end = len(cells)
    for c in range(len(start) - 1, -1, -1):
        end -= start[c]
        start[c] = end
    for i in range(len(cells)):
        order[start[cells[i]]] = i
        start[cells[i]] += 1
    for c in range(len(start) - 1, 0, -1):
        start[c] = start[c - 1]
    start[0] = 0


Steps = NDArray[np.int32]
"""Steps of a scale, by cell."""

NEVER_COVERED = -1
"""Step of a cell that has never been covered."""

COVERAGE_CELL = 4.0
"""Side of the cells of the coverage [px]."""

COVERAGE_REACH = 4
"""Cells to each side within which a newly covered cell counts as near."""


class Coverage(NamedTuple):
    r"""Coverage of an image; its arrays are never written to, since later states share them.

    Attributes
    ----------
    found : ndarray of int32, shape (\*cells)
        Step at which each cell was first covered, -1 for never.
    latest : ndarray of int32, shape (\*cells)
        Latest such step among the cells around each.
    size : int
        Number of covered cells.
    """

    found: Steps
    latest: Steps
    size: int


def no_coverage(shape: Extent) -> Coverage:
    """Return the coverage of an image of this shape before any particle has been on an edge."""
    never = np.full(tuple(int(n / COVERAGE_CELL) + 1 for n in shape), NEVER_COVERED, np.int32)
    return Coverage(never, never, 0)


def mark_covered(coverage: Coverage, positions: Array, on_edge: Mask, step: int) -> tuple[Coverage, int]:
    """Mark the cells of particles on edges as covered at a step.

    `positions`, shape (N, 2) [px], are the particles, `on_edge`, shape (N,), is their edge contact. Returns the
    coverage afterwards, the same one if no cell is new, and the number of newly covered cells.
    """
    row, col = cell_indices(positions[on_edge], coverage.found.shape)
    if (coverage.found[row, col] != NEVER_COVERED).all():  # as mostly, without a copy of large arrays
        return coverage, 0
    found, latest = coverage.found.copy(), coverage.latest.copy()
    new = _mark_new_cells(found, latest, positions, on_edge, step)
    return Coverage(found, latest, coverage.size + new), new


@compiled
def _mark_new_cells(found: Steps, latest: Steps, positions: Array, on_edge: Mask, step: int) -> int:
    """Mark the cells of particles on edges in `found`, and those near new ones in `latest`; return how many are new."""
    new, (rows, cols) = 0, found.shape
    for i in range(len(positions)):
        if not on_edge[i]:
            continue
        row, col = cell_of(positions[i, 0], COVERAGE_CELL, rows), cell_of(positions[i, 1], COVERAGE_CELL, cols)
        if found[row, col] != NEVER_COVERED:
            continue
        found[row, col] = step
        new += 1
        for r in range(max(row - COVERAGE_REACH, 0), min(row + COVERAGE_REACH + 1, rows)):
            for c in range(max(col - COVERAGE_REACH, 0), min(col + COVERAGE_REACH + 1, cols)):
                latest[r, c] = step
    return new


def cell_indices(positions: Array, shape: Extent) -> Index:
    """Return row and column of the cells, of which there are so many, of positions, shape (N, 2), shape (2, N)."""
    return np.clip((positions + 0.5) / COVERAGE_CELL, 0, np.array(shape) - 1).astype(np.int64).T


def idle_steps_at(coverage: Coverage, positions: Array, step: int, elsewhere: int) -> Index:
    """Count the steps since cells around each particle were newly covered, shape (N,); `elsewhere` if none ever was."""
    idle = np.empty(len(positions), np.int64)
    _count_idle_steps(coverage.latest, positions, step, elsewhere, idle)
    return idle


@compiled
def _count_idle_steps(latest: Steps, positions: Array, step: int, elsewhere: int, idle: Index) -> None:
    """Write what `idle_steps_at` returns."""
    rows, cols = latest.shape
    for i in range(len(positions)):
        row, col = cell_of(positions[i, 0], COVERAGE_CELL, rows), cell_of(positions[i, 1], COVERAGE_CELL, cols)
        newest = latest[row, col]
        idle[i] = elsewhere if newest == NEVER_COVERED else step - newest


def with_times_reset(coverage: Coverage, step: int) -> Coverage:
    """Return the coverage as if all covered cells had been newly covered at this step."""
    found, latest = (np.where(steps == NEVER_COVERED, steps, np.int32(step)) for steps in coverage[:2])
    return Coverage(found, latest, coverage.size)


def with_times_reset_near(coverage: Coverage, places: Array, reach: float, step: int) -> Coverage:
    """Return the coverage as if all cells within reach of positions, shape (K, D) [px], were near a new one."""
    latest = coverage.latest.copy()
    for place in places:
        parts, away = [], []
        for along, x in zip(latest.shape, place, strict=True):
            first, last = (cell_of(x + sign * reach, COVERAGE_CELL, along) for sign in (-1, 1))
            parts.append(slice(first, last + 1))
            middle = COVERAGE_CELL * (np.arange(first, last + 1) + 0.5) - 0.5
            away.append(np.maximum(np.abs(middle - x) - 0.5 * COVERAGE_CELL, 0.0) ** 2)
        latest[tuple(parts)][reduce(np.add.outer, away) < reach**2] = step
    return coverage._replace(latest=latest)


_SIDE_DIRECTION = np.array([1.0, 0.37, 0.21])
"""Direction that distinguishes the sides of a surface: in no plane of a usual grid."""

_CELLS_PER_AXIS = 1 << 20
"""Cells along an axis that fit into the number of a cell."""


class SurfaceCoverage(NamedTuple):
    """Coverage of a volume.

    Attributes
    ----------
    cells : ndarray of int64, shape (K,)
        Numbers of the cells found, with their sides, in ascending order.
    side : float
        Side of a cell [units].
    """

    cells: Index
    side: float

    @property
    def size(self) -> int:
        """Number of cells found, each side for itself."""
        return len(self.cells)


def no_surface_coverage(side: float = 1.0) -> SurfaceCoverage:
    """Return the coverage before any surface has been found, with cells of this side [units]."""
    return SurfaceCoverage(np.zeros(0, np.int64), side)


def surface_cells(places: Array, normals: Array, side: float) -> Index:
    """Return the number of the cell and side of each particle, shape (N,), at places, with normals, shape (N, 3)."""
    cell = np.floor(places / side).astype(np.int64) + 1
    number = (cell[:, 0] * _CELLS_PER_AXIS + cell[:, 1]) * _CELLS_PER_AXIS + cell[:, 2]
    return 2 * number + (normals @ _SIDE_DIRECTION > 0.0)


def cover_surfaces(coverage: SurfaceCoverage, places: Array, normals: Array) -> tuple[SurfaceCoverage, Mask]:
    """Cover the cells of particles on surfaces, shape (N, 3); return a mask, shape (N,), of the first in new cells."""
    number = surface_cells(places, normals, coverage.side)
    new, first = np.unique(number, return_index=True)
    place = np.searchsorted(coverage.cells, new)
    known = np.zeros(len(new), bool)
    inside = place < len(coverage.cells)
    known[inside] = coverage.cells[place[inside]] == new[inside]
    fresh = np.zeros(len(places), bool)
    fresh[first[~known]] = True
    return coverage._replace(cells=np.insert(coverage.cells, place[~known], new[~known])), fresh
