"""Insertion and deletion of particles (section 3.6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.interpolation import flattened, sample, sample_one
from cpm_core.kernels import compiled
from cpm_core.level import GATE, Level
from cpm_core.neighbors import block, build_cells, cell_of, crowded, squared_distance
from cpm_core.parameters import Parameters

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_FAINTEST_STEP = 0.35
"""Edge strength that a new particle's place must have, as a fraction of its parents'."""

_ROOM = 0.55
"""Distance, in d_min, that a place between two particles must keep from all others."""

_STRIDE, _STRIDE_ROOM = 0.9, 0.8
"""Distance, in d_min, of a place ahead of a particle, and what it must keep from all others."""

_DIRECTIONS = 8
"""Directions in which a particle looks for a place ahead."""

_SLIDES, _SLIDE = 8, 0.6
"""Times that a place is moved by the Lorentz force, and by how much of it [px]; across an edge the force falls from one
to zero within half a pixel, so that each move takes off most of the distance."""

_RESTING = 0.2
"""Lorentz force under which a place then counts as one to rest on."""


@dataclass(frozen=True, eq=False, slots=True)
class Births:
    """New particles: where, and between which two (the same twice for a place ahead of one)."""

    position: Array
    parent: Index
    other: Index


def on_edge(felt: Array, floor: float) -> NDArray[np.bool_]:
    """Which particles sit on an edge.

    Parameters
    ----------
    felt : ndarray, shape (N, 2 D + 1)
        Lorentz force, gradient and edge strength at each, see `Level.felt`.
    floor : float
        Weakest edge strength that counts.

    Returns
    -------
    ndarray of bool, shape (N,)
        Whether the interpolated unit field has fallen below the gate and the edge is strong enough.
    """
    dimension = felt.shape[1] // 2
    lorentz = np.einsum("ni,ni->n", felt[:, :dimension], felt[:, :dimension])
    return np.asarray((lorentz < GATE**2) & (felt[:, -1] >= floor))


def deletion(positions: Array, strength: Array, shape: tuple[int, ...], d_min: float) -> NDArray[np.bool_]:
    """Choose the particles that stay: of two nearer than ``d_min / 2`` the one on the weaker edge goes.

    Parameters
    ----------
    positions : ndarray, shape (N, D)
        Particles [px].
    strength : ndarray, shape (N,)
        Edge strength at each; among equals the earlier particle stays.
    shape : tuple of int
        Shape of the image.
    d_min : float
        Spacing [px].

    Returns
    -------
    ndarray of bool, shape (N,)
        Whether each stays.
    """
    order = np.argsort(-strength, kind="stable")
    return _thin(positions, order, np.array(shape), 0.5 * d_min)


@compiled
def _thin(positions: Array, order: Index, extent: Index, distance: float) -> NDArray[np.bool_]:
    count, dimension = positions.shape
    cells, head, following = build_cells(positions[:0], extent, distance, count)
    near = np.empty(3**dimension, np.int64)
    kept = np.zeros(count, np.bool_)
    for n in range(count):
        i = order[n]
        if not crowded(positions[i], distance, positions, distance, cells, head, following, near):
            kept[i] = True
            cell = cell_of(positions[i], distance, cells)
            following[i] = head[cell]
            head[cell] = i
    return kept


def insertion(
    positions: Array,
    seated: NDArray[np.bool_],
    looking: NDArray[np.bool_],
    level: Level,
    d_max: float,
    parameters: Parameters,
) -> Births:
    """Find places for new particles.

    Two rules. Between: two seated particles at ``d_min < d <= d_min + d_max`` with nothing between them get one at
    their midpoint, as in section 3.6, if the edge goes on there. Ahead: a seated particle that sees the edge go on
    within one spacing, with nobody on it, gets one there. Annealing ends the first rule; the second one does not depend
    on it and carries a front along every edge that is connected to the one it sits on, through bends and junctions.

    Parameters
    ----------
    positions : ndarray, shape (N, D)
        Particles [px].
    seated : ndarray of bool, shape (N,)
        Which of them sit on an edge.
    looking : ndarray of bool, shape (N,)
        Which of them look ahead.
    level : Level
        The scale's fields.
    d_max : float
        Annealed insertion range [px].
    parameters : Parameters
        For `d_min`.

    Returns
    -------
    Births
        The new particles.
    """
    d_min = parameters.d_min
    reach = d_min + d_max
    room = 3 * len(positions) + 16
    position = np.empty((room, positions.shape[1]))
    position[: len(positions)] = positions
    parent = np.empty((room - len(positions), 2), np.int64)
    shape = np.array(level.shape, dtype=np.int64)
    felt, turns = flattened(level.felt), _turns(positions.shape[1])
    first = len(positions)
    last = _find_places(position, first, seated, looking, felt, shape, d_min, reach, level.floor, turns, parent)
    return Births(position[first:last].copy(), parent[: last - first, 0].copy(), parent[: last - first, 1].copy())


def _turns(dimension: int) -> Array:
    """Unit vectors in which to look ahead, in opposite pairs."""
    if dimension != 2:
        raise ValueError(f"the image has {dimension} dimensions but must have 2.")
    angle = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    return np.stack([np.sin(angle), np.cos(angle)], axis=1)


@compiled
def _find_places(
    position: Array,
    count: int,
    seated: NDArray[np.bool_],
    looking: NDArray[np.bool_],
    flat: Array,
    shape: Index,
    d_min: float,
    reach: float,
    floor: float,
    turns: Array,
    parent: Index,
) -> int:
    """Append the places of new particles to `position` and return how many particles there are then."""
    dimension = shape.size
    size = max(reach, d_min)
    cells, head, following = build_cells(position[:count], shape, size, len(position))
    near = np.empty(3**dimension, np.int64)
    far = np.empty(3**dimension, np.int64)
    felt = np.empty(len(flat))
    place = np.empty(dimension)
    last = count
    for i in range(count):
        if not seated[i]:
            continue
        faintest = max(floor, _FAINTEST_STEP * sample_one(flat[-1], shape, position[i]))
        for n in range(block(position[i], size, cells, 1, far)):
            j = head[far[n]]
            while j >= 0:
                if i < j < count and seated[j] and last < len(position):
                    squared = squared_distance(position[i], position[j])
                    if d_min * d_min < squared <= reach * reach:
                        for k in range(dimension):
                            place[k] = 0.5 * (position[i, k] + position[j, k])
                        # nothing between: neither near the midpoint nor in the circle over the pair
                        free = max(_ROOM * d_min, 0.5 * np.sqrt(squared) - 1e-9)
                        if sample_one(flat[-1], shape, place) >= faintest and not crowded(
                            place, free, position, size, cells, head, following, near
                        ):
                            last = _settle(place, i, j, position, last, parent, count, size, cells, head, following)
                j = following[j]
        if not looking[i]:
            continue
        for t in range(len(turns)):
            for k in range(dimension):
                place[k] = position[i, k] + _STRIDE * d_min * turns[t, k]
            if last == len(position) or sample_one(flat[-1], shape, place) < faintest:
                continue
            if crowded(place, _STRIDE_ROOM * d_min, position, size, cells, head, following, near):
                continue
            if not _relax(flat, shape, place, felt, faintest, 0.5 * d_min):
                continue
            if not crowded(place, _STRIDE_ROOM * d_min, position, size, cells, head, following, near):
                last = _settle(place, i, i, position, last, parent, count, size, cells, head, following)
    return last


@compiled
def _settle(
    place: Array,
    one: int,
    two: int,
    position: Array,
    last: int,
    parent: Index,
    count: int,
    size: float,
    cells: Index,
    head: Index,
    following: Index,
) -> int:
    position[last] = place
    parent[last - count, 0] = one
    parent[last - count, 1] = two
    cell = cell_of(place, size, cells)
    following[last] = head[cell]
    head[cell] = last
    return last + 1


@compiled
def _relax(flat: Array, shape: Index, place: Array, felt: Array, faintest: float, farthest: float) -> bool:
    """Let a place slide along the Lorentz force; tell whether it comes to rest on an edge within reach."""
    dimension = shape.size
    start = place.copy()
    for slide in range(_SLIDES + 1):
        for k in range(dimension):
            if place[k] < 0.0 or place[k] > shape[k] - 1.0:
                return False
        sample(flat, shape, place, felt)
        if felt[-1] < faintest:
            return False
        if slide < _SLIDES:
            for k in range(dimension):
                place[k] += _SLIDE * felt[k]
    size = 0.0
    for k in range(dimension):
        size += felt[k] ** 2
    return size < _RESTING**2 and squared_distance(place, start) < farthest * farthest
