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

from cpm_core.field.interpolation import EDGE_STRENGTH, FORCE_COL, FORCE_ROW, GRADIENT_COL, GRADIENT_ROW
from cpm_core.field.scale_field import ON_EDGE_FORCE, ScaleField
from cpm_core.model.coverage import COVERAGE_CELL, COVERAGE_REACH, NEVER_COVERED, Coverage, cell_indices
from cpm_core.model.equations import IDLE_STEPS
from cpm_core.model.interventions import allowed_places
from cpm_core.model.plane.motion import edge_contact_at
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.state import State
from cpm_core.numerics.grids import run_in_bands
from cpm_core.numerics.types import Array, Index, Mask, Single

_MIN_THINNED_PIXELS = 2**20
"""Pixels of an image above which the coarsest scale begins with fewer seeds, and a finer one after any start."""

_SEED_CELLS = 4
"""Cells to each side of an edge in which seeds are kept: more than two seeds of a grid of 8 px. Seeds are everywhere if
no place of the image is farther from one."""

Directions = NDArray[np.uint8]
"""Directions in which an image rises across the edges in each cell, a bit for each eighth of a turn."""

_EIGHTHS = (1 << np.arange(8)).astype(np.uint8)
_EXPLAINED = np.bitwise_or.reduce([np.roll(_EIGHTHS, turn) for turn in range(-2, 3)])
"""Directions of edges that a particle explains, by its own one: a right angle to each side."""


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
    # also in the cells beside its own, as its place on the finer scale is not yet exact
    around = cell_indices(place, shape)[:, None] + np.mgrid[-1:2, -1:2].reshape(2, 9, 1)
    _mark_cells(explained, around, _EXPLAINED[_directions(edge_contact_at(place, field)[2])])
    return edges != 0, (edges & ~explained) != 0


def _dilate_cells(cells: Mask, reach: int) -> Mask:
    """Mark some cells and those near them, to each side."""
    return np.asarray(scipy.ndimage.maximum_filter(cells, 2 * reach + 1), bool)


def _directions(slopes: Array) -> Index:
    """Return the eighths of a turn in which slopes, shape (N, 2), rise."""
    return (4.0 * (np.arctan2(*slopes.T) / np.pi + 1.0)).astype(np.int64) % 8


def _mark_cells(cells: Directions, places: Index, bits: Directions) -> None:
    """Add bits to some cells, rows and columns of shape (2, ...); those beyond belong to the ends."""
    flat = np.ravel_multi_index(tuple(places), cells.shape, mode="clip")
    np.bitwise_or.at(cells.reshape(-1), flat.ravel(), np.broadcast_to(bits, flat.shape).ravel())


def _mark_edges(packed: Single, floor: float, edges: Directions, first: int, end: int) -> None:
    """Mark some rows of cells that contain pixels on edges."""
    size = int(COVERAGE_CELL)
    lines = packed[first * size : None if end == len(edges) else end * size]
    weak = lines[..., FORCE_ROW] ** 2 + lines[..., FORCE_COL] ** 2 < ON_EDGE_FORCE**2
    row, col = np.nonzero(weak & (lines[..., EDGE_STRENGTH] >= floor))
    slopes = lines[row, col, GRADIENT_ROW : GRADIENT_COL + 1].astype(float)
    cells = cell_indices(np.stack([row + first * size, col], axis=1), edges.shape)
    _mark_cells(edges, cells, _EIGHTHS[_directions(slopes)])
