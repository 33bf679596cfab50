"""Insertion of particles (section 3.6)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from cpm_core.dynamics.edge_contact import EdgeContact
from cpm_core.field.plane import between, component
from cpm_core.field.scale_field import FAINTEST, ScaleField
from cpm_core.image.barriers import BarrierMap, crosses
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list import Cells, cell_of, cells_around, row_of_cells

Place = tuple[bool, float, float, float, int]
"""Whether it is free, where, what it must keep from everybody [px], and how many stand about."""

_STRIDE, _STRIDE_ROOM = 0.9, 0.8
"""Distance, in d_min, of a place ahead of a particle, and what it must keep from all others."""

_CROWD_RANGE, _CROWD = 1.5, 3
"""Distance, in d_min, within which a place may have at most so many particles: more are two rows on one edge."""

_DIRECTIONS = 2.0 * np.pi * np.arange(8) / 8
_TURNS = np.stack([np.sin(_DIRECTIONS), np.cos(_DIRECTIONS)], axis=1)
"""Unit vectors in which a particle looks for a place ahead, in opposite pairs."""

_ALONG = 0.36
"""Square of the part of a direction across the edge up to which it counts as along the edge."""

_FLANK = 1.6
"""Distance, in d_min, of others on both sides along an edge between which there is no place for a stride."""

_SLIDES, _SLIDE = 6, 1.0
"""Times that a place is moved by the Lorentz force, and by how much of it [px]; across an edge the force falls from one
to zero within a pixel or more, so that each move takes off a good part of the distance."""

_RESTING, _RESTED = 0.2, 0.1
"""Lorentz force under which a place then counts as one to rest on, and under which it need not be moved any more."""

_MOST_PLACES = 8
"""Places that one particle may offer in a step."""

_MOST_NEAR, _NEAR_RANGE = 64, 2.75
"""Particles within a distance from one, in d_min, beyond which there is certainly no room for more."""

_FULL = 1_000_000
"""More than any number of particles: what counts where one is nearer than the room that a place must have."""

_WORTH_A_THREAD = 400
"""Particles from which on a second thread makes the search faster."""


@dataclass(frozen=True, eq=False, slots=True)
class Births:
    """New particles: where, and between which two (the same twice for a place ahead of one)."""

    position: Array
    parent: Index
    other: Index


class _Rule(NamedTuple):
    """What a place must fulfil.

    Attributes
    ----------
    floor : float
        Weakest edge strength that counts.
    d_min, reach : float
        Spacing, and annealed distance up to which two get one between them [px].
    range : float
        How far off particles are looked at [px].
    """

    floor: float
    d_min: float
    reach: float
    range: float


def search_range(parameters: Parameters) -> float:
    """Distance up to which a step looks at the particles around one [px]."""
    d_min, reach = parameters.d_min, parameters.d_min + parameters.d_max
    return max(reach, 0.5 * reach + _CROWD_RANGE * d_min, (_STRIDE + _CROWD_RANGE) * d_min)


def insertion(
    contact: EdgeContact,
    present: Mask,
    looking: Mask,
    thorough: Mask,
    ahead: Mask,
    scale_field: ScaleField,
    d_max: float,
    parameters: Parameters,
    turn: int = 0,
) -> Births:
    """Find places for new particles.

    Two rules. Between: two seated particles at ``d_min < d <= d_min + d_max`` with nothing between them get one at
    their midpoint, as in section 3.6, if the edge goes on there and its crest is free beside the midpoint. Ahead: a
    seated particle that sees the edge go on within one spacing, with nobody on it, gets one there. Annealing ends the
    first rule; the second one does not depend on it and carries a front along every edge that is connected to the one
    it sits on, through bends and junctions. Neither of them reaches across a wall.

    Parameters
    ----------
    contact : EdgeContact
        How the particles stand.
    present : ndarray of bool, shape (N,)
        Which of them are still there.
    looking : ndarray of bool, shape (N,)
        Which of them look for places in this step.
    thorough : ndarray of bool, shape (N,)
        Which of those do so even if they have others on both sides along their edge.
    ahead : ndarray of bool, shape (N,)
        Which of those look ahead as well.
    scale_field : ScaleField
        The scale's fields.
    d_max : float
        Annealed insertion range [px].
    parameters : Parameters
        For `d_min`.
    turn : int
        Which pair of opposite directions is looked into besides those along the edge; they take turns.

    Returns
    -------
    Births
        The new particles.
    """
    count = len(contact.strength)
    rule = _Rule(scale_field.floor, parameters.d_min, parameters.d_min + d_max, search_range(parameters))
    offers = np.empty(count, np.int64)
    place, other = np.empty((count, _MOST_PLACES, 2)), np.empty((count, _MOST_PLACES), np.int64)
    room, crowd = np.empty((count, _MOST_PLACES)), np.empty((count, _MOST_PLACES), np.int64)
    breeding, thorough = contact.on_edge & present, thorough & looking
    there = present[contact.cells.order]
    asks = (
        contact.cells,
        contact.strength,
        there,
        breeding,
        looking,
        thorough,
        ahead,
        scale_field.packed,
        scale_field.barrier_map,
        rule,
    )
    work = partial(_find_places, *asks, _TURNS, turn, offers, place, other, room, crowd)
    share(work, count, _WORTH_A_THREAD)
    most = int(offers.sum())
    position, parents = np.empty((most, 2)), np.empty((most, 2), np.int64)
    born = 0
    if most:
        born = _occupy(contact.cells, offers, place, other, room, crowd, parameters.d_min, position, parents)
    return Births(position[:born], parents[:born, 0], parents[:born, 1])


@compiled
def _find_places(
    cells: Cells,
    strength: Array,
    present: Mask,
    breeding: Mask,
    looking: Mask,
    thorough: Mask,
    ahead: Mask,
    packed: Single,
    barrier_map: BarrierMap,
    rule: _Rule,
    turns: Array,
    turn: int,
    offers: Index,
    place: Array,
    other: Index,
    room: Array,
    crowd: Index,
    first: int,
    last: int,
) -> None:
    """Let some of the sorted particles look for places, as if nobody else did; each offers some."""
    # a wider range holds more of them
    most = min(int(_MOST_NEAR * max(1.0, rule.range / (_NEAR_RANGE * rule.d_min)) ** 2), len(cells.order) + 1)
    near_y, near_x, index = np.empty(most + 1), np.empty(most + 1), np.empty(most + 1, np.int64)
    here, there = np.empty(2), np.empty(2)
    walled = len(barrier_map.segments) > 0
    for k in range(first, last):
        i, y, x = cells.order[k], cells.y[k], cells.x[k]
        offers[i] = 0
        if not (breeding[i] and looking[i]):
            continue
        if not thorough[i] and _is_flanked(cells, present, y, x, packed, _FLANK * rule.d_min):
            continue
        length = _list_near(cells, present, y, x, rule.range, near_y, near_x, index)
        if length == most:
            continue
        faintest = max(rule.floor, FAINTEST * strength[i])
        offered = 0
        for n in range(length + len(turns)):
            j, far_y, far_x = i, y, x
            if n < length:
                j, far_y, far_x = index[n], near_y[n], near_x[n]
                if not (breeding[j] and (j > i or not thorough[j])):
                    continue
                free, p_y, p_x, keep, about = _halfway(
                    near_y, near_x, length, y, x, far_y, far_x, packed, faintest, rule
                )
            elif ahead[i]:
                down, right = turns[n - length, 0], turns[n - length, 1]
                if (n - length - turn) % (len(turns) // 2) and not _is_along(packed, y, x, down, right):
                    continue
                free, p_y, p_x, keep, about = _ahead(near_y, near_x, length, y, x, down, right, packed, faintest, rule)
                far_y, far_x = p_y, p_x
            else:
                break
            if not free or offered == _MOST_PLACES:
                continue
            if walled:
                here[0], here[1], there[0], there[1] = y, x, far_y, far_x
                if crosses(barrier_map, here, there):
                    continue
            place[i, offered, 0], place[i, offered, 1] = p_y, p_x
            other[i, offered], room[i, offered], crowd[i, offered] = j, keep, about
            offered += 1
        offers[i] = offered


@compiled
def _halfway(
    near_y: Array,
    near_x: Array,
    length: int,
    y: float,
    x: float,
    far_y: float,
    far_x: float,
    packed: Single,
    faintest: float,
    rule: _Rule,
) -> Place:
    """Place halfway between two particles, if there is one and the crest beside it is not another row's."""
    squared = (far_y - y) ** 2 + (far_x - x) ** 2
    keep = 0.5 * np.sqrt(squared) - 1e-9  # nothing between: nobody in the circle over the pair
    p_y, p_x, about = 0.5 * (y + far_y), 0.5 * (x + far_x), _FULL
    free = rule.d_min**2 < squared <= rule.reach**2
    if free:
        about = _crowd(near_y, near_x, length, p_y, p_x, keep, rule.d_min)
        free = about <= _CROWD
    if free:
        free, c_y, c_x = _relax(packed, faintest, 0.5 * rule.d_min, p_y, p_x)
        free = free and _crowd(near_y, near_x, length, c_y, c_x, keep, rule.d_min) <= _CROWD
    return free, p_y, p_x, keep, about


@compiled
def _ahead(
    near_y: Array,
    near_x: Array,
    length: int,
    y: float,
    x: float,
    down: float,
    right: float,
    packed: Single,
    faintest: float,
    rule: _Rule,
) -> Place:
    """Place one stride from a particle, if its edge, or one that meets it, goes on there without anybody."""
    keep, about = _STRIDE_ROOM * rule.d_min, _FULL
    p_y, p_x = y + _STRIDE * rule.d_min * down, x + _STRIDE * rule.d_min * right
    free = _crowd(near_y, near_x, length, p_y, p_x, keep, rule.d_min) < _FULL  # cheap, and hardly any direction passes
    if free:
        free, p_y, p_x = _relax(packed, faintest, 0.5 * rule.d_min, p_y, p_x)
    if free:
        about = _crowd(near_y, near_x, length, p_y, p_x, keep, rule.d_min)
        free = about <= _CROWD
    return free, p_y, p_x, keep, about


@compiled
def _is_flanked(cells: Cells, present: Mask, y: float, x: float, packed: Single, distance: float) -> bool:
    """Whether a particle has others on both sides along its edge, so near that there is no place ahead of it."""
    at = between(packed, y, x)
    n_y, n_x = component(packed, 2, at), component(packed, 3, at)
    before, behind = 0, 0
    top, bottom, left, right = cells_around(cells, y, x, distance)
    for row in range(top, bottom + 1):
        first, last = row_of_cells(cells, row, left, right)
        for k in range(first, last):
            d_y, d_x = cells.y[k] - y, cells.x[k] - x
            across, along = d_y * n_y + d_x * n_x, d_y * n_x - d_x * n_y
            near = (d_y**2 + d_x**2 < distance**2) & (across**2 < along**2) & present[k]
            before += near & (along > 0.0)
            behind += near & (along < 0.0)
    return before > 0 and behind > 0


@compiled
def _is_along(packed: Single, y: float, x: float, down: float, right: float) -> bool:
    """Whether a direction is along the edge at a place."""
    at = between(packed, y, x)
    n_y, n_x = component(packed, 2, at), component(packed, 3, at)
    return (down * n_y + right * n_x) ** 2 <= _ALONG * (n_y**2 + n_x**2)


@compiled
def _list_near(
    cells: Cells, present: Mask, y: float, x: float, distance: float, near_y: Array, near_x: Array, index: Index
) -> int:
    """List the particles around a place; return how many they are, or one less than fit in if they are more."""
    length = 0
    top, bottom, left, right = cells_around(cells, y, x, distance)
    for row in range(top, bottom + 1):
        first, last = row_of_cells(cells, row, left, right)
        for k in range(first, last):
            near_y[length], near_x[length], index[length] = cells.y[k], cells.x[k], cells.order[k]
            # what does not count is written over by the next one: cheaper than to guess whether it will
            counts = ((cells.y[k] - y) ** 2 + (cells.x[k] - x) ** 2 < distance**2) & present[k]
            length += counts & (length < len(near_y) - 1)
    return length


@compiled
def _crowd(near_y: Array, near_x: Array, length: int, y: float, x: float, room: float, d_min: float) -> int:
    """Particles about a place; more than any number if one is nearer than the room that the place must have."""
    crowd = 0
    for n in range(length):
        squared = (near_y[n] - y) ** 2 + (near_x[n] - x) ** 2
        crowd += 1 if squared < (_CROWD_RANGE * d_min) ** 2 else 0
        crowd += _FULL if squared < room * room else 0
    return crowd


@compiled
def _relax(packed: Single, faintest: float, farthest: float, y: float, x: float) -> tuple[bool, float, float]:
    """Let a place slide along the Lorentz force; tell whether it comes to rest on an edge within reach, and where."""
    start_y, start_x = y, x
    for slide in range(_SLIDES + 1):
        if not (0.0 <= y <= packed.shape[0] - 1.0 and 0.0 <= x <= packed.shape[1] - 1.0):
            break
        if (y - start_y) ** 2 + (x - start_x) ** 2 >= farthest**2:
            break
        place = between(packed, y, x)
        if component(packed, 4, place) < faintest:
            break
        f_y, f_x = component(packed, 0, place), component(packed, 1, place)
        squared = f_y**2 + f_x**2
        if slide == _SLIDES or squared < _RESTED**2:
            return squared < _RESTING**2, y, x
        y += _SLIDE * f_y
        x += _SLIDE * f_x
    return False, y, x


@compiled
def _occupy(
    cells: Cells,
    offers: Index,
    place: Array,
    other: Index,
    room: Array,
    crowd: Index,
    d_min: float,
    position: Array,
    parents: Index,
) -> int:
    """Put particles on the places that are offered, in turn, as long as they keep their distance from one another."""
    newest = np.full(cells.rows * cells.cols, -1, np.int64)
    earlier = np.empty(len(position), np.int64)
    born = 0
    for i in range(len(offers)):
        for n in range(offers[i]):
            y, x = place[i, n, 0], place[i, n, 1]
            row, col = cell_of(y, cells.size, cells.rows), cell_of(x, cells.size, cells.cols)
            about = crowd[i, n]
            for r in range(max(row - 1, 0), min(row + 2, cells.rows)):
                for c in range(max(col - 1, 0), min(col + 2, cells.cols)):
                    j = newest[r * cells.cols + c]
                    while j >= 0:
                        squared = (position[j, 0] - y) ** 2 + (position[j, 1] - x) ** 2
                        about += 1 if squared < (_CROWD_RANGE * d_min) ** 2 else 0
                        about += _FULL if squared < room[i, n] ** 2 else 0
                        j = earlier[j]
            if about <= _CROWD:
                position[born, 0], position[born, 1] = y, x
                parents[born, 0], parents[born, 1] = i, other[i, n]
                earlier[born] = newest[row * cells.cols + col]
                newest[row * cells.cols + col] = born
                born += 1
    return born
