"""Insertion and deletion of particles (section 3.6)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.interpolation import flattened, sample, sample_one
from cpm_core.kernels import compiled
from cpm_core.level import FAINTEST, GATE, Level
from cpm_core.neighbors import Cells, block, build_cells, count_near, sort_in, squared_distance
from cpm_core.parameters import Parameters
from cpm_core.walls import Walls, crosses

Array = NDArray[np.float64]
Index = NDArray[np.int64]

_STRIDE, _STRIDE_ROOM = 0.9, 0.8
"""Distance, in d_min, of a place ahead of a particle, and what it must keep from all others."""

_CROWD_RANGE, _CROWD = 1.5, 3
"""Distance, in d_min, within which a place may have at most so many particles: more are two rows on one edge."""

_DIRECTIONS = 8
"""Directions in which a particle looks for a place ahead."""

_SLIDES, _SLIDE = 8, 0.6
"""Times that a place is moved by the Lorentz force, and by how much of it [px]; across an edge the force falls from one
to zero within about a pixel, so that each move takes off most of the distance."""

_RESTING = 0.2
"""Lorentz force under which a place then counts as one to rest on."""


@dataclass(frozen=True, eq=False, slots=True)
class Births:
    """New particles: where, and between which two (the same twice for a place ahead of one)."""

    position: Array
    parent: Index
    other: Index


class _Terrain(NamedTuple):
    """What the search for places needs, as a plain tuple for the compiled loops.

    Attributes
    ----------
    felt : ndarray, shape (2 D + 1, M)
        `Level.felt`, flattened.
    shape : ndarray of int64, shape (D,)
        Shape of the image.
    floor : float
        Weakest edge strength that counts.
    d_min, d_max : float
        Spacing and annealed insertion range [px].
    place, there : ndarray, shapes (D,) and (2 D + 1,)
        Scratch for the place that is looked at, and for what a particle would feel there.
    """

    felt: Array
    shape: Index
    floor: float
    d_min: float
    d_max: float
    place: Array
    there: Array


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
def _thin(position: Array, order: Index, extent: Index, distance: float) -> NDArray[np.bool_]:
    cells = build_cells(position, 0, extent, distance)
    kept = np.zeros(len(position), np.bool_)
    for n in range(order.size):
        i = order[n]
        if count_near(cells, position[i], distance) == 0:
            kept[i] = True
            sort_in(cells, i)
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
    Neither of them reaches across a wall.

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
    count, dimension = positions.shape
    position = np.empty((3 * count + 16, dimension))
    position[:count] = positions
    parent = np.empty((len(position), 2), np.int64)
    terrain = _Terrain(
        felt=flattened(level.felt),
        shape=np.array(level.shape, dtype=np.int64),
        floor=level.floor,
        d_min=parameters.d_min,
        d_max=d_max,
        place=np.empty(dimension),
        there=np.empty(2 * dimension + 1),
    )
    last = _find_places(position, count, seated, looking, terrain, level.walls, _turns(dimension), parent)
    return Births(position[count:last].copy(), parent[count:last, 0].copy(), parent[count:last, 1].copy())


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
    terrain: _Terrain,
    walls: Walls,
    turns: Array,
    parent: Index,
) -> int:
    """Append the places of new particles to `position` and return how many particles there are then."""
    size = max(terrain.d_min + terrain.d_max, _CROWD_RANGE * terrain.d_min)
    cells = build_cells(position, count, terrain.shape, size)
    last = count
    for i in range(count):
        if seated[i]:
            faintest = max(terrain.floor, FAINTEST * sample_one(terrain.felt[-1], terrain.shape, position[i]))
            last = _fill_between(cells, i, count, last, seated, terrain, walls, faintest, parent)
            if looking[i]:
                last = _look_ahead(cells, i, last, terrain, walls, faintest, turns, parent)
    return last


@compiled
def _fill_between(
    cells: Cells,
    i: int,
    count: int,
    last: int,
    seated: NDArray[np.bool_],
    terrain: _Terrain,
    walls: Walls,
    faintest: float,
    parent: Index,
) -> int:
    """Places halfway between particle `i` and later ones."""
    position, place, d_min = cells.position, terrain.place, terrain.d_min
    reach = d_min + terrain.d_max
    around = np.empty(cells.around.size, np.int64)
    for n in range(block(cells, position[i], 1, around)):
        j = cells.head[around[n]]
        while j >= 0:
            if i < j < count and seated[j]:
                squared = squared_distance(position[i], position[j])
                if d_min * d_min < squared <= reach * reach:
                    for k in range(place.size):
                        place[k] = 0.5 * (position[i, k] + position[j, k])
                    # nothing between: nobody in the circle over the pair
                    free = 0.5 * np.sqrt(squared) - 1e-9
                    if (
                        sample_one(terrain.felt[-1], terrain.shape, place) >= faintest
                        and _is_free(cells, place, free, d_min)
                        and not crosses(walls, position[i], position[j])
                    ):
                        last = _occupy(cells, last, place, i, j, parent)
            j = cells.following[j]
    return last


@compiled
def _look_ahead(
    cells: Cells, i: int, last: int, terrain: _Terrain, walls: Walls, faintest: float, turns: Array, parent: Index
) -> int:
    """Places one stride from particle `i` where its edge, or one that meets it, goes on."""
    place, d_min = terrain.place, terrain.d_min
    room = _STRIDE_ROOM * d_min
    for t in range(len(turns)):
        for k in range(place.size):
            place[k] = cells.position[i, k] + _STRIDE * d_min * turns[t, k]
        # the cheap tests first: hardly any direction passes them
        if (
            sample_one(terrain.felt[-1], terrain.shape, place) >= faintest
            and count_near(cells, place, room) == 0
            and _relax(terrain, faintest, 0.5 * d_min)
            and _is_free(cells, place, room, d_min)
            and not crosses(walls, cells.position[i], place)
        ):
            last = _occupy(cells, last, place, i, i, parent)
    return last


@compiled
def _is_free(cells: Cells, place: Array, room: float, d_min: float) -> bool:
    """Whether a place keeps its distance, and is not beside a second row of particles on the same edge."""
    return count_near(cells, place, room) == 0 and count_near(cells, place, _CROWD_RANGE * d_min) <= _CROWD


@compiled
def _occupy(cells: Cells, last: int, place: Array, one: int, other: int, parent: Index) -> int:
    """Put a particle on a place, if there is room for one more; return how many there are then."""
    if last == len(cells.position):
        return last
    cells.position[last] = place
    parent[last, 0] = one
    parent[last, 1] = other
    sort_in(cells, last)
    return last + 1


@compiled
def _relax(terrain: _Terrain, faintest: float, farthest: float) -> bool:
    """Let the place slide along the Lorentz force; tell whether it comes to rest on an edge within reach."""
    place, there = terrain.place, terrain.there
    start = place.copy()
    for slide in range(_SLIDES + 1):
        for k in range(place.size):
            if place[k] < 0.0 or place[k] > terrain.shape[k] - 1.0:
                return False
        sample(terrain.felt, terrain.shape, place, there)
        if there[-1] < faintest:
            return False
        if slide < _SLIDES:
            for k in range(place.size):
                place[k] += _SLIDE * there[k]
    size = 0.0
    for k in range(place.size):
        size += there[k] ** 2
    return size < _RESTING**2 and squared_distance(place, start) < farthest * farthest
