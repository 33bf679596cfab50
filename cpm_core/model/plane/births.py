"""Insertion and deletion of particles in the plane (section 3.6).

Between: two particles on edges at ``d_min < d <= d_min + d_max`` with nothing between them get one at their midpoint,
as in section 3.6, if the edge continues there and its ridge is free next to the midpoint. The front of a row is moved
by repulsion alone. Two rules let rows begin. Alone: a particle without another one in reach gets one to each side along
its edge. Beside: where another edge begins, at a junction or behind a thin object, the particle next to it gets one
there. None of them reaches across a barrier.

Of two particles nearer than half of ``d_min`` the one on the weaker edge is deleted, and of equal ones the later. A
deleted particle deletes no other: particles are examined from the strongest edge to the weakest, and each is compared
with those that stay.
"""

from __future__ import annotations

from functools import partial
from typing import Any, NamedTuple

import numpy as np

from cpm_core.field.interpolation import EDGE_STRENGTH, FORCE_COL, FORCE_ROW, interpolate_component, pixel_before
from cpm_core.field.scale_field import EDGE_END_FRACTION, ScaleField
from cpm_core.image.regions import BarrierMap, crosses_barrier
from cpm_core.model.coverage import cell_of
from cpm_core.model.equations import DELETION_DISTANCE
from cpm_core.model.plane.motion import READ_AHEAD_COUNT, edge_state_at, prefetch_field
from cpm_core.model.plane.repulsion import PlaneCells, cells_around, row_of_cells
from cpm_core.model.state import Particles
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Index, Mask, Single, record
from cpm_core.numerics.vectors import keep_apart
from cpm_core.parameters import Parameters


@record
class EdgeContact:
    """Edge contact and neighbors of the particles of a step.

    Attributes
    ----------
    strength : ndarray, shape (N,)
        Edge strength at each.
    on_edge : ndarray of bool, shape (N,)
        Which are on an edge; see `is_on_edge`.
    normal : ndarray, shape (N, 2)
        Image gradient at each.
    cells : PlaneCells
        The particles sorted into cells, for neighbors up to a distance.
    """

    strength: Array
    on_edge: Mask
    normal: Array
    cells: PlaneCells


_EXAMINED_PER_THREAD = 1500
"""Particles from which a second thread examines them faster."""


def examine_contacts(
    cells: PlaneCells, has_moved: Mask, scale_field: ScaleField, d_min: float
) -> tuple[EdgeContact, Mask]:
    """Examine the edge contact of the particles in `cells`, and which have a neighbor nearer than half of `d_min` [px].

    Of two such particles at least one is among those that have moved since the last time, `has_moved`, shape (N,).
    """
    count = len(cells.order)
    edge, close = (np.empty(count), np.empty(count, np.bool_), np.empty((count, 2))), np.zeros(count, np.bool_)
    work = partial(
        _examine_particles,
        cells,
        has_moved,
        DELETION_DISTANCE * d_min,
        scale_field.packed,
        scale_field.floor,
        edge,
        close,
    )
    run_in_parallel(work, count, _EXAMINED_PER_THREAD)
    return EdgeContact(*edge, cells), close


@compiled
def _examine_particles(
    cells: PlaneCells,
    has_moved: Mask,
    distance: float,
    packed: Single,
    floor: float,
    edge: tuple[Array, Mask, Array],
    close: Mask,
    first: int,
    last: int,
) -> None:
    """Write what `examine_contacts` returns for some of the sorted particles."""
    strength, on_edge, normal = edge
    for k in range(first, last):
        if (k - first) % READ_AHEAD_COUNT == 0:
            prefetch_field(packed, cells, k, last, strength)
        i, y, x = cells.order[k], cells.y[k], cells.x[k]
        strength[i], on_edge[i], normal[i, 0], normal[i, 1] = edge_state_at(packed, y, x, floor)
        if not has_moved[i]:
            continue
        top, bottom, left, right = cells_around(cells, y, x, distance)
        for row in range(top, bottom + 1):
            start, end = row_of_cells(cells, row, left, right)
            for other in range(start, end):
                squared = (cells.y[other] - y) ** 2 + (cells.x[other] - x) ** 2
                if squared < distance * distance and other != k:
                    close[i] = close[cells.order[other]] = True


def select_survivors(position: Array, strength: Array, d_min: float, close: Mask | None = None) -> Mask:
    """Return a mask, shape (N,), of the particles at `position`, shape (N, 2), that stay.

    Of two nearer than ``d_min / 2`` [px] the one on the weaker edge is deleted; with equal `strength`, shape (N,), the
    later one. Where it is known which have such a neighbor, they are marked in `close`, shape (N,).
    """
    near = np.arange(len(position)) if close is None else np.flatnonzero(close)
    kept = np.ones(len(position), np.bool_)
    if len(near):
        order = near[np.argsort(-strength[near], kind="stable")]
        kept[order] = keep_apart(position[order], DELETION_DISTANCE * d_min)
    return kept


CROWD_RANGE = 1.5
"""Distance within which particles around a position are counted, in d_min."""

MAX_CROWD = 3
"""Largest number of particles within that distance: more are two rows on one edge."""


@record
class PlaneBirths:
    """New particles, shape (M, 2), and the two parents of each (the same twice for a position beside one)."""

    position: Array
    parents: Index


class PlaceRule(NamedTuple):
    """Conditions on a position.

    Attributes
    ----------
    floor : float
        Least edge strength.
    d_min : float
        Spacing [px].
    range : float
        Distance up to which other particles are examined [px].
    """

    floor: float
    d_min: float
    range: float


def search_range(parameters: Parameters) -> float:
    """Return the distance up to which a step examines the particles around one [px]."""
    d_min, reach = parameters.d_min, parameters.d_min + parameters.d_max
    return max(reach, 0.5 * reach + CROWD_RANGE * d_min)


FoundPlace = tuple[bool, float, float, float, int]
"""Whether it is free, where, its distance from all others [px], and the number of particles around it."""

_ROOM_BESIDE = 0.8
"""Least distance of a position beside a particle from all particles, in d_min."""

_BRANCH_STRIDE = 1.5
"""Distance across its edge, in d_min, at which a particle looks for another edge: nearer to the ridge of a stronger
edge a weaker one that meets it has no ridge of its own."""

_MAX_SLIDES = 6
"""Number of times that a position is moved by the Lorentz force."""

_SLIDE_LENGTH = 1.0
"""Distance of such a move for a unit force [px]: across an edge the force falls from one to zero within a pixel or
more, so that each move removes a good part of the distance."""

_MAX_EDGE_FORCE = 0.2
"""Lorentz force under which a position is then on an edge."""

_SETTLED_FORCE = 0.1
"""Lorentz force under which a position need not be moved any more."""

_MAX_OFFERS = 8
"""Number of positions that one particle may offer in a step."""

_MAX_NEAR_PARTICLES = 64
"""Number of particles near one beyond which there is certainly no room for more."""

_CROWDED_RANGE = 2.75
"""Distance within which that number counts, in d_min."""

_OVERFULL_COUNT = 1_000_000
"""More than any number of particles: the count around a position where a particle is too near."""

_INITIAL_OFFER_ROWS = 64
"""Initial number of rows for offers."""

_PLANE_SEARCHES_PER_THREAD = 300
"""Number of searching particles from which a second thread makes it faster."""


_Offers = Array
"""Positions that particles offer, a row for each: the particle, the second of the two next to the position (the first
itself for one beside it), the position [px], its distance from all other particles [px], and how many are around."""


def find_insertions(
    contact: EdgeContact,
    present: Mask,
    looking: Mask,
    scale_field: ScaleField,
    insertion_range: Array,
    parameters: Parameters,
) -> PlaneBirths:
    """Find positions for new particles.

    Of the particles `present`, which have not been deleted, those `looking` search, both of shape (N,).
    `insertion_range`, shape (N,), is what annealing has left of d_max for each [px]: of two particles the larger one
    counts, and where nothing is left none is born beside one either.
    """
    count, d_min = len(contact.strength), parameters.d_min
    rule = PlaceRule(scale_field.floor, d_min, search_range(parameters))
    eligible, there = contact.on_edge & present, present[contact.cells.order]
    edge = (contact.strength, contact.normal)
    seen = (contact.cells, *edge, there, looking & eligible, eligible, scale_field.packed, scale_field.barrier_map)
    found: dict[int, _Offers] = {}

    def search_some(first: int, last: int) -> None:
        found[first] = _find_offers(*seen, insertion_range, rule, first, last)

    searching = int(np.count_nonzero(looking & eligible))
    run_in_parallel(search_some, count, _PLANE_SEARCHES_PER_THREAD * count // (searching + 1) + 1)
    offers = np.concatenate([found[first] for first in sorted(found)])
    offers = offers[np.argsort(offers[:, 0], kind="stable")]
    position, parents = np.empty((len(offers), 2)), np.empty((len(offers), 2), np.int64)
    newest, earlier = np.full(len(contact.cells.start), -1), np.empty(len(offers), np.int64)
    born = _insert_apart(contact.cells, offers, d_min, newest, earlier, position, parents) if len(offers) else 0
    return PlaneBirths(position[:born], parents[:born])


@compiled
def _find_offers(
    cells: PlaneCells,
    strength: Array,
    normal: Array,
    present: Mask,
    looking: Mask,
    eligible: Mask,
    packed: Single,
    barrier_map: BarrierMap,
    insertion_range: Array,
    rule: PlaceRule,
    first: int,
    last: int,
) -> _Offers:
    """Let some of the sorted particles search for positions, each as if alone; `present` is in their order."""
    # a wider range contains more particles
    most = min(
        int(_MAX_NEAR_PARTICLES * max(1.0, rule.range / (_CROWDED_RANGE * rule.d_min)) ** 2), len(cells.order) + 1
    )
    near, index = np.empty((2, most + 1)), np.empty(most + 1, np.int64)
    here, there = np.empty(2), np.empty(2)
    offers, count = np.empty((_INITIAL_OFFER_ROWS, 6)), 0
    for k in range(first, last):
        i, y, x = cells.order[k], cells.y[k], cells.x[k]
        if not looking[i]:
            continue
        n_y, n_x = normal[i, 0], normal[i, 1]
        length = _list_near_particles(cells, present, y, x, rule.range, near, index)
        if length == most:
            continue
        faintest, before = max(rule.floor, EDGE_END_FRACTION * strength[i]), count
        if count + _MAX_OFFERS > len(offers):
            former, offers = offers, np.empty((2 * len(offers), 6))
            for n in range(count):
                for item in range(6):
                    offers[n, item] = former[n, item]
        stride = rule.d_min / max(np.sqrt(n_y**2 + n_x**2), 1e-30)
        for way in range(4):  # to both sides along its edge, and across it
            if (length > 1 and way < 2) or insertion_range[i] == 0.0:
                continue
            step = stride if way % 2 else -stride
            across = _BRANCH_STRIDE * step
            down, right = (step * n_x, -step * n_y) if way < 2 else (across * n_y, across * n_x)
            found = _find_place_beside(near, length, y + down, x + right, packed, faintest, rule)
            here[0], here[1], there[0], there[1] = y, x, found[1], found[2]
            if found[0] and not crosses_barrier(barrier_map, here, there):
                offers[count, 0], offers[count, 1] = i, i
                offers[count, 2], offers[count, 3], offers[count, 4], offers[count, 5] = found[1:]
                count += 1
        for n in range(length):
            j, far_y, far_x = index[n], near[0, n], near[1, n]
            farthest = rule.d_min + max(insertion_range[i], insertion_range[j])
            apart = rule.d_min**2 < (far_y - y) ** 2 + (far_x - x) ** 2 <= farthest**2
            if not (apart and eligible[j] and (j > i or not looking[j])):
                continue
            found = _find_midpoint(near, length, y, x, far_y, far_x, packed, faintest, rule)
            if not found[0] or count - before == _MAX_OFFERS:
                continue
            here[0], here[1], there[0], there[1] = y, x, far_y, far_x
            if not crosses_barrier(barrier_map, here, there):
                offers[count, 0], offers[count, 1] = i, j
                offers[count, 2], offers[count, 3], offers[count, 4], offers[count, 5] = found[1:]
                count += 1
    return offers[:count]


@compiled
def _find_midpoint(
    near: Array,
    length: int,
    y: float,
    x: float,
    far_y: float,
    far_x: float,
    packed: Single,
    faintest: float,
    rule: PlaceRule,
) -> FoundPlace:
    """Return the midpoint of two particles, if it is free and the ridge next to it belongs to no other row."""
    # nothing between: no particle in the circle over the pair
    keep = 0.5 * np.sqrt((far_y - y) ** 2 + (far_x - x) ** 2) - 1e-9
    p_y, p_x = 0.5 * (y + far_y), 0.5 * (x + far_x)
    about = _count_crowd(near, length, p_y, p_x, keep, rule.d_min)
    free = about <= MAX_CROWD
    if free:
        free, c_y, c_x = _slide_to_edge(packed, faintest, 0.5 * rule.d_min, p_y, p_x)
        free = free and _count_crowd(near, length, c_y, c_x, keep, rule.d_min) <= MAX_CROWD
    return free, p_y, p_x, keep, about


@compiled
def _find_place_beside(
    near: Array, length: int, y: float, x: float, packed: Single, faintest: float, rule: PlaceRule
) -> FoundPlace:
    """Return the position on an edge next to one beside a particle, if there is an edge with room."""
    keep = _ROOM_BESIDE * rule.d_min
    free, y, x = _slide_to_edge(packed, faintest, 0.5 * rule.d_min, y, x)
    about = _count_crowd(near, length, y, x, keep, rule.d_min)
    return free and about <= MAX_CROWD, y, x, keep, about


@compiled
def _list_near_particles(
    cells: PlaneCells, present: Mask, y: float, x: float, distance: float, near: Array, index: Index
) -> int:
    """List the particles around a position; return their number, at most one less than fit in."""
    length = 0
    top, bottom, left, right = cells_around(cells, y, x, distance)
    for row in range(top, bottom + 1):
        first, last = row_of_cells(cells, row, left, right)
        for k in range(first, last):
            near[0, length], near[1, length], index[length] = cells.y[k], cells.x[k], cells.order[k]
            # a particle that does not count is overwritten by the next one, which is cheaper than a branch
            counts = ((cells.y[k] - y) ** 2 + (cells.x[k] - x) ** 2 < distance**2) & present[k]
            length += counts & (length < len(index) - 1)
    return length


@compiled
def _count_crowd(near: Array, length: int, y: float, x: float, room: float, d_min: float) -> int:
    """Count the particles around a position; more than any number if one is nearer than `room`."""
    crowd = 0
    for n in range(length):
        squared = (near[0, n] - y) ** 2 + (near[1, n] - x) ** 2
        crowd += 1 if squared < (CROWD_RANGE * d_min) ** 2 else 0
        crowd += _OVERFULL_COUNT if squared < room * room else 0
    return crowd


@compiled
def _slide_to_edge(packed: Single, faintest: float, farthest: float, y: float, x: float) -> tuple[bool, float, float]:
    """Let a position slide along the Lorentz force; return whether it ends on an edge within reach, and where."""
    start_y, start_x = y, x
    for slide in range(_MAX_SLIDES + 1):
        if not (0.0 <= y <= packed.shape[0] - 1.0 and 0.0 <= x <= packed.shape[1] - 1.0):
            break
        if (y - start_y) ** 2 + (x - start_x) ** 2 >= farthest**2:
            break
        place = pixel_before(packed, y, x)
        if interpolate_component(packed, EDGE_STRENGTH, place) < faintest:
            break
        f_y, f_x = interpolate_component(packed, FORCE_ROW, place), interpolate_component(packed, FORCE_COL, place)
        squared = f_y**2 + f_x**2
        if slide == _MAX_SLIDES or squared < _SETTLED_FORCE**2:
            return squared < _MAX_EDGE_FORCE**2, y, x
        y += _SLIDE_LENGTH * f_y
        x += _SLIDE_LENGTH * f_x
    return False, y, x


@compiled
def _insert_apart(
    cells: PlaneCells, offers: _Offers, d_min: float, newest: Index, earlier: Index, position: Array, parents: Index
) -> int:
    """Insert particles at the offered positions, in order, if they keep their distance from one another.

    `newest` of each cell, none yet, and the one `earlier` in its cell than each, are written as well.
    """
    born = 0
    for i in range(len(offers)):
        y, x = offers[i, 2], offers[i, 3]
        row, col = cell_of(y, cells.size, cells.rows), cell_of(x, cells.size, cells.cols)
        about = int(offers[i, 5])
        for r in range(max(row - 1, 0), min(row + 2, cells.rows)):
            for c in range(max(col - 1, 0), min(col + 2, cells.cols)):
                j = newest[r * cells.cols + c]
                while j >= 0:
                    squared = (position[j, 0] - y) ** 2 + (position[j, 1] - x) ** 2
                    about += 1 if squared < (CROWD_RANGE * d_min) ** 2 else 0
                    about += _OVERFULL_COUNT if squared < offers[i, 4] ** 2 else 0
                    j = earlier[j]
        if about <= MAX_CROWD:
            position[born, 0], position[born, 1] = y, x
            parents[born, 0], parents[born, 1] = int(offers[i, 0]), int(offers[i, 1])
            earlier[born] = newest[row * cells.cols + col]
            newest[row * cells.cols + col] = born
            born += 1
    return born


def replace_particles(particles: Particles, stay: Index, births: PlaneBirths, first_identity: int) -> Particles:
    """Return the particles with the indices `stay`, in this order, and the new ones, numbered from `first_identity`.

    `stay` has the shape (K,).
    New ones have the mean velocity and force history of their two parents.
    """
    one, other = births.parents.T
    kept, born = len(stay), len(births.position)

    def join(array: Any, new: Any = None) -> Any:
        joined = np.empty((kept + born, *array.shape[1:]), array.dtype)
        np.take(array, stay, 0, joined[:kept], "clip")  # without a copy, and three times as fast as array[stay]
        joined[kept:] = 0.5 * (array[one] + array[other]) if new is None else new
        return joined

    return Particles(
        join(particles.position, births.position),
        join(particles.velocity),
        join(particles.force),
        join(particles.distance, np.nan),
        join(particles.identity, first_identity + np.arange(born)),
        join(particles.crept),
    )
