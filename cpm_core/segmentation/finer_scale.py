"""Beginning of a finer scale after a start everywhere: the particles of the coarser one, and the seeds still needed.

Every scale begins with all seeds, so that objects too small for the coarser one are found as well. Most of them follow
the field to an edge with particles on it and are deleted there. After a start everywhere these are most of the
particles that move.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.field.interpolation import GRADIENT_COL, GRADIENT_ROW, interpolate_component, pixel_before
from cpm_core.field.scale_field import ON_EDGE_FORCE, ScaleField
from cpm_core.model.coverage import COVERAGE_CELL, COVERAGE_REACH, NEVER_COVERED, Coverage, cell_indices, cell_of
from cpm_core.model.equations import IDLE_STEPS
from cpm_core.model.interventions import allowed_places
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.state import State
from cpm_core.numerics.grids import run_in_bands
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask, Single

_MIN_THINNED_PIXELS = 2**20
"""Pixels of an image above which the coarsest scale begins with fewer seeds, and a finer one after any start."""

_EXPLAINED_CELLS = 1
"""Cells to each side of a particle, whose place on the finer scale is not yet exact, in which it explains edges."""

_SEED_CELLS = 4
"""Cells to each side of an edge in which seeds are kept: more than two seeds of a grid of 8 px. Seeds are everywhere if
no place of the image is farther from one."""

Directions = NDArray[np.uint8]
"""Directions in which an image rises across the edges in each cell, a bit for each eighth of a turn."""


def thin_seeds(state: State) -> State:
    """Thin the first state of a run in a large image to one seed in each cell, if there are more seeds than cells.

    The seeds that are left out take part from the next finer scale on.
    """
    if not isinstance(state, PlaneState) or math.prod(state.shape) <= _MIN_THINNED_PIXELS:
        return state
    cells = state.coverage.found.shape
    if state.count <= math.prod(cells):
        return state
    place = np.ravel_multi_index(tuple(cell_indices(state.particles.position, cells)), cells)
    return replace(state, particles=state.particles.select(np.sort(np.unique(place, return_index=True)[1])))


def drop_explained_seeds(state: State, field: ScaleField) -> State:
    """Keep of the seeds of a scale only those near an edge that no particle explains yet; return its first state.

    An edge is explained by a particle of the coarser scale near it where the image rises in about the same direction,
    so that one side of a thin object does not explain the other. It counts as covered for as long as the coarser scale
    had to be idle to end: repulsion need not spread the particles along it once more.

    All seeds stay if some edge that is not explained has no seed near it: particles may come to it from afar. They also
    stay in a small image in which they are not everywhere.
    """
    if not isinstance(state, PlaneState):
        return state
    first = state.count - len(allowed_places(state.start, state.scale, state.shape, state.regions))
    place = state.particles.position
    seeds = np.zeros(state.coverage.found.shape, bool)
    row, col = cell_indices(place[first:], seeds.shape)
    seeds[row, col] = True
    if (
        math.prod(state.shape) <= _MIN_THINNED_PIXELS
        and not _dilate_cells(seeds, max(_SEED_CELLS >> state.scale, 1)).all()
    ):
        return state
    edges, missing = find_unexplained_edges(field, place[:first], seeds.shape)
    if not _dilate_cells(seeds, _SEED_CELLS)[missing].all():
        return state
    stay = np.concatenate([np.ones(first, bool), _dilate_cells(missing, _SEED_CELLS)[row, col]])
    known = edges & ~missing
    found, latest = (
        np.where(cells, -IDLE_STEPS, NEVER_COVERED).astype(np.int32)
        for cells in (known, _dilate_cells(known, COVERAGE_REACH))
    )
    coverage = Coverage(found, latest, int(np.count_nonzero(known)))
    return replace(state, particles=state.particles.keep(stay), coverage=coverage)


def find_unexplained_edges(field: ScaleField, place: Array, shape: tuple[int, ...]) -> tuple[Mask, Mask]:
    """Return masks of cells, of this shape, with edges, and with edges that particles, shape (N, 2), do not explain."""
    edges, explained = np.zeros((2, *shape), np.uint8)
    packed = field.packed  # made here: threads that find it missing would each make it
    run_in_bands(partial(_mark_edges, packed, field.floor, edges), len(edges))
    _mark_explained(packed, place, explained)
    return edges != 0, (edges & ~explained) != 0


def _dilate_cells(cells: Mask, reach: int) -> Mask:
    """Mark some cells and those near them, to each side."""
    return np.asarray(scipy.ndimage.maximum_filter(cells, 2 * reach + 1), bool)


@compiled
def _direction_at(packed: Single, y: float, x: float) -> int:
    """Return the eighth of a turn in which an image rises at a position."""
    place = pixel_before(packed, y, x)
    down, right = interpolate_component(packed, GRADIENT_ROW, place), interpolate_component(packed, GRADIENT_COL, place)
    return int(4.0 * (np.arctan2(down, right) / np.pi + 1.0)) % 8


@compiled
def _mark_edges(packed: Single, floor: float, edges: Directions, first: int, end: int) -> None:
    """Mark some rows of cells that contain pixels on edges."""
    size, beyond = int(COVERAGE_CELL), packed.shape[0]
    for row in range(first * size, beyond if end == len(edges) else min(end * size, beyond)):
        for col in range(packed.shape[1]):
            if packed[row, col, 4] >= floor and packed[row, col, 0] ** 2 + packed[row, col, 1] ** 2 < ON_EDGE_FORCE**2:
                cell = cell_of(row, COVERAGE_CELL, edges.shape[0]), cell_of(col, COVERAGE_CELL, edges.shape[1])
                edges[cell] |= np.uint8(1 << _direction_at(packed, row, col))


@compiled
def _mark_explained(packed: Single, place: Array, explained: Directions) -> None:
    """Mark the directions of edges that particles explain, a right angle to each side, in the cells around them."""
    rows, cols = explained.shape
    for i in range(len(place)):
        direction, bits = _direction_at(packed, place[i, 0], place[i, 1]), 0
        for turn in range(-2, 3):
            bits |= 1 << (direction + turn) % 8
        row, col = cell_of(place[i, 0], COVERAGE_CELL, rows), cell_of(place[i, 1], COVERAGE_CELL, cols)
        for r in range(max(row - _EXPLAINED_CELLS, 0), min(row + _EXPLAINED_CELLS + 1, rows)):
            for c in range(max(col - _EXPLAINED_CELLS, 0), min(col + _EXPLAINED_CELLS + 1, cols)):
                explained[r, c] |= np.uint8(bits)
