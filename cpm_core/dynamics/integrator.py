"""The motion of all particles in one time step: the laws of `dynamics`, applied to each in one compiled loop.

A particle that has come to rest where nothing new is found sleeps: nothing that could move it changes any more, and it
is passed over until there is new ground near it or other parameters set the run going again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.dynamics.edge_contact import contact_at, on_edge_at
from cpm_core.dynamics.equations import (
    FADED,
    LATEST,
    advance,
    damped_series,
    damping,
    is_stuck,
    normalised_coulomb,
    repulsion_left,
)
from cpm_core.field.plane import between, component
from cpm_core.field.scale_field import GATE, ScaleField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list import Cells, build_cells, cell_of, cells_around, row_of_cells
from cpm_core.particles.coulomb.mesh_force import FAR_EVERY, NOTHING_FAR, FarForce, far_at, far_force, nodes
from cpm_core.particles.state import MEMORY, Particles, State

Bits = NDArray[np.int32]
Four = tuple[float, float, float, float]

_REACH = 2.0
"""Reach of the pairs where there is a mesh for the others, in d_min + d_max."""

_LONELY = 8.0
"""Distance at which a particle is looked for at most when the two nearest ones are wanted, in d_min + d_max."""

_ASLEEP = 5e-4
"""Speed under which a particle sleeps where nothing new has been found for long [px / unit of time]."""

_PAIRS_A_NODE = 40
"""Pairs that are summed in the time that a node of the padded mesh takes, spread over the steps that it serves for."""

_WORTH_A_THREAD = 400
"""Particles from which on a second thread makes the step faster."""

_FEW = 8
"""Particles up to which it is faster to ask about each of them than about all."""

_LANES = 16
"""Numbers that are worked on at once: lists are filled up to a multiple of it."""

_NOWHERE = 1e6
"""Place of what fills up a list [px]; its force is next to nothing, and its cube is still a number."""

_SAME_SPOT = 1e-10
"""Squared distance below which two particles stand on the same spot: a bound instead of a branch keeps the loop on
vector registers, and a pair on one spot adds its vanishing distance, which is nothing."""

_INFINITE = np.float32(np.inf).view(np.int32)
"""Bits of infinity."""


@dataclass(frozen=True, eq=False, slots=True)
class Moved:
    """Particles after a step.

    Attributes
    ----------
    particles : Particles
        All of them.
    motion : ndarray, shape (N,)
        Distance that each has moved [px].
    strength : ndarray, shape (N,)
        Edge strength at each.
    on_edge : ndarray of bool, shape (N,)
        Which of them sit on an edge.
    """

    particles: Particles
    motion: Array
    strength: Array
    on_edge: Mask

    def where(self, kept: Mask) -> Moved:
        """Those particles for which `kept`, shape (N,), is true."""
        return Moved(self.particles.where(kept), self.motion[kept], self.strength[kept], self.on_edge[kept])

    def held_at(self, particles: Particles, start: Array, scale_field: ScaleField) -> Moved:
        """Where walls have let the particles go from `start`, shape (N, 2); they have moved no farther."""
        particles.distance[:, 0] = np.linalg.norm(particles.position, axis=1)
        motion = np.linalg.norm(particles.position - start, axis=1)
        return Moved(particles, motion, *contact_at(particles.position, scale_field))


class _Law(NamedTuple):
    """The parameters of motion."""

    w1: float
    w2: float
    d_min: float
    dt: float
    lonely: float


def far_force_for(particles: Particles, idle: Index, scale_field: ScaleField, parameters: Parameters) -> FarForce:
    """Far force of a step, or none where summing all pairs is faster or nobody feels them.

    Parameters
    ----------
    particles : Particles
        Before the step.
    idle : ndarray of int64, shape (N,)
        Steps since there was new ground around each.
    scale_field : ScaleField
        Fields of the scale.
    parameters : Parameters
        For `d_min` and `d_max`.
    """
    reach = _REACH * (parameters.d_min + parameters.d_max)
    feeling = np.count_nonzero(idle < FADED)
    if feeling * len(particles) < _PAIRS_A_NODE * nodes(scale_field.shape, reach):
        return NOTHING_FAR
    return far_force(particles.position, scale_field.shape, reach)


def far_force_of(state: State, idle: Index, scale_field: ScaleField, parameters: Parameters) -> FarForce:
    """Far force of the step after a state: the one that serves, or a new one when its time has come."""
    if state.step_of_scale % FAR_EVERY == 0 or state.far is None:
        return far_force_for(state.particles, idle, scale_field, parameters)
    return state.far


def move(particles: Particles, idle: Index, far: FarForce, scale_field: ScaleField, parameters: Parameters) -> Moved:
    """One time step of all particles.

    Parameters
    ----------
    particles : Particles
        Before the step.
    idle : ndarray of int64, shape (N,)
        Steps since there was new ground around each.
    far : FarForce
        Far part of the Coulomb force.
    scale_field : ScaleField
        Fields of the scale.
    parameters : Parameters
        Obeyed at once.

    Returns
    -------
    Moved
        After the step.
    """
    cells = _cells(particles, far, scale_field.shape)
    moved, work = _prepared(particles, cells, idle, far, scale_field.packed, scale_field.floor, parameters)
    share(work, len(particles), _WORTH_A_THREAD)
    return moved


def undamped_force(
    particles: Particles,
    index: Index,
    idle: Index,
    far: FarForce,
    packed: Single,
    shape: tuple[int, ...],
    parameters: Parameters,
) -> Array:
    """Force of eq. (12) on some of the particles but for the damping, with what friction leaves of it.

    Parameters
    ----------
    particles : Particles
        All of them.
    index : ndarray of int64, shape (M,)
        Which are asked about.
    idle : ndarray of int64, shape (N,)
        Steps since there was new ground around each.
    far : FarForce
        Far part of the Coulomb force.
    packed : ndarray of float32, shape (H, W, 5)
        What is felt on the pixels; see `ScaleField`.
    shape : tuple of int
        Shape of the image at the scale.
    parameters : Parameters
        Weights, and what the Coulomb force is normalised by.

    Returns
    -------
    ndarray, shape (M, 2)
        The force; of particles that are asleep that of their last step.
    """
    cells = _cells(particles, far, shape)
    moved, work = _prepared(particles, cells, idle, far, packed, np.inf, parameters)
    if len(index) > _FEW:
        share(work, len(particles), _WORTH_A_THREAD)
    else:
        rank = np.empty(len(particles), np.int64)
        rank[cells.order] = np.arange(len(particles))
        for k in rank[index].tolist():
            work(k, k + 1)
    return moved.particles.force.take(index, axis=0)[:, 0]


def is_asleep(particles: Particles, idle: Index) -> Mask:
    """Which particles are passed over in the next step, shape (N,)."""
    slow = np.einsum("ni,ni->n", particles.velocity, particles.velocity) < _ASLEEP**2
    return np.asarray(slow & (idle >= FADED) & ~particles.young)


def _cells(particles: Particles, far: FarForce, shape: tuple[int, ...]) -> Cells:
    """Particles on an image of this shape, sorted by the reach of their pairs."""
    height, width = shape
    size = far.reach if np.isfinite(far.reach) else float(max(height, width) + 1)
    return build_cells(particles.position, height, width, size)


def _prepared(
    particles: Particles,
    cells: Cells,
    idle: Index,
    far: FarForce,
    packed: Single,
    floor: float,
    parameters: Parameters,
) -> tuple[Moved, Callable[[int, int], object]]:
    """Where a step will be found, and what carries it out for some of the sorted particles."""
    law = _Law(
        w1=parameters.w1,
        w2=parameters.w2,
        d_min=parameters.d_min,
        dt=parameters.time_step,
        lonely=_LONELY * (parameters.d_min + parameters.d_max),
    )
    damped = _damped(parameters.beta, parameters.time_step)
    after = Particles(
        np.empty_like(particles.position),
        np.empty_like(particles.velocity),
        np.empty_like(particles.force),
        np.empty_like(particles.distance),
        particles.identity,
    )
    motion = np.empty(len(particles))
    before = (particles.velocity, particles.force, particles.distance)
    strength, on_edge = np.empty(len(particles)), np.empty(len(particles), np.bool_)
    to = (after.position, after.velocity, after.force, after.distance, motion, strength, on_edge)
    work = partial(_move, cells, packed, idle, far, damped, law, before, to, floor)
    return Moved(after, motion, strength, on_edge), work


@lru_cache(maxsize=8)
def _damped(beta: float, dt: float) -> Array:
    """Series of the damped motion after every number of steps without news, the last one for all that are later."""
    return np.array([damped_series(damping(beta, idle) * dt) for idle in range(LATEST + 1)])


@compiled
def _move(
    cells: Cells,
    packed: Single,
    idle: Index,
    far: FarForce,
    damped: Array,
    law: _Law,
    before: tuple[Array, Array, Array],
    after: tuple[Array, Array, Array, Array, Array, Array, Mask],
    floor: float,
    first: int,
    last: int,
) -> None:
    """Move some of the sorted particles."""
    velocity, force, distance = before
    to_position, to_velocity, to_force, to_distance, motion, strength, on_edge = after
    room = len(cells.order) + _LANES
    near_y, near_x, squared = np.empty(room, np.float32), np.empty(room, np.float32), np.empty(room, np.float32)
    bits = squared.view(np.int32)
    size, bend, smooth = cells.size, far.bend, far.force
    listed, length, own = -1, 0, 0
    for k in range(first, last):
        i, y, x = cells.order[k], cells.y[k], cells.x[k]
        left = repulsion_left(idle[i])
        v_y, v_x = velocity[i, 0], velocity[i, 1]
        for t in range(MEMORY - 1):
            to_distance[i, t + 1] = distance[i, t]
        if left == 0.0 and v_y**2 + v_x**2 < _ASLEEP**2 and not np.isnan(distance[i, MEMORY - 1]):
            to_position[i, 0], to_position[i, 1], to_velocity[i, 0], to_velocity[i, 1] = y, x, 0.0, 0.0
            for axis in range(2):
                to_force[i, 0, axis], to_force[i, 1, axis] = force[i, 0, axis], force[i, 1, axis]
            to_distance[i, 0] = np.sqrt(y**2 + x**2)
            motion[i] = 0.0
            strength[i], on_edge[i] = on_edge_at(packed, y, x, floor)
            continue
        c_y, c_x = 0.0, 0.0
        if left > 0.0:
            row, col = cell_of(y, size, cells.rows), cell_of(x, size, cells.cols)
            if row * cells.cols + col != listed:
                listed = row * cells.cols + col
                length, own = _gather(cells, row, col, near_y, near_x)
            # from the list: the same difference, were it rounded otherwise here, would make a particle push itself
            here_y, here_x = near_y[own + k], near_x[own + k]
            c_y, c_x = _pair_sum(near_y, near_x, squared, length, here_y, here_x, np.float32(far.reach), bend)
            if len(smooth):
                far_y, far_x = far_at(smooth, (y - far.top) / far.pitch, (x - far.left) / far.pitch)
                c_y, c_x = c_y + far_y, c_x + far_x
            one, other = _two_nearest(squared, bits, length)
            if other > size**2:  # somebody outside the list may be nearer
                one, other = _two_nearest_of_many(cells, y, x, law.lonely)
            spacing = 0.5 * (min(np.sqrt(one), law.lonely) + min(np.sqrt(other), law.lonely))
            c_y, c_x = normalised_coulomb(c_y, c_x, spacing, law.d_min)
            c_y, c_x = left * c_y, left * c_x
        history = (force[i, 0, 0], force[i, 0, 1], force[i, 1, 0], force[i, 1, 1])
        late = min(idle[i], len(damped) - 1)
        series = (damped[late, 0], damped[late, 1], damped[late, 2], damped[late, 3])
        to_y, to_x, v_y, v_x, history = _step(packed, law, idle[i], series, y, x, v_y, v_x, c_y, c_x, history)
        to_position[i, 0], to_position[i, 1], to_velocity[i, 0], to_velocity[i, 1] = to_y, to_x, v_y, v_x
        to_force[i, 0, 0], to_force[i, 0, 1], to_force[i, 1, 0], to_force[i, 1, 1] = history
        to_distance[i, 0] = np.sqrt(to_y**2 + to_x**2)
        motion[i] = np.sqrt((to_y - y) ** 2 + (to_x - x) ** 2)
        strength[i], on_edge[i] = on_edge_at(packed, to_y, to_x, floor)


@compiled
def _step(
    packed: Single,
    law: _Law,
    idle: int,
    series: Four,
    y: float,
    x: float,
    v_y: float,
    v_x: float,
    c_y: float,
    c_x: float,
    history: Four,
) -> tuple[float, float, float, float, Four]:
    """Total force of eq. (12) on a particle under the Coulomb force c, and the step of eq. (14)-(15)."""
    last_y, last_x, old_y, old_x = history
    place = between(packed, y, x)
    l_y, l_x = component(packed, 0, place), component(packed, 1, place)
    f_y, f_x = law.w1 * c_y + law.w2 * l_y, law.w1 * c_x + law.w2 * l_x
    if l_y**2 + l_x**2 < GATE**2:
        n_y, n_x = component(packed, 2, place), component(packed, 3, place)
        size = max(np.sqrt(n_y**2 + n_x**2), 1e-30)
        n_y, n_x = n_y / size, n_x / size
        if is_stuck(_along(f_y, f_x, n_y, n_x), _along(v_y, v_x, n_y, n_x), law.w1, idle):
            f_y, f_x = _across(f_y, f_x, n_y, n_x)
            v_y, v_x = _across(v_y, v_x, n_y, n_x)
            last_y, last_x = _across(last_y, last_x, n_y, n_x)
            old_y, old_x = _across(old_y, old_x, n_y, n_x)
    to_y, v_y = advance(y, v_y, f_y, last_y, old_y, law.dt, series)
    to_x, v_x = advance(x, v_x, f_x, last_x, old_x, law.dt, series)
    return to_y, to_x, v_y, v_x, (f_y, f_x, last_y, last_x)


@compiled
def _across(a_y: float, a_x: float, n_y: float, n_x: float) -> tuple[float, float]:
    """Part of a vector along the unit vector n, which is across the edge that n is normal to."""
    size = a_y * n_y + a_x * n_x
    return size * n_y, size * n_x


@compiled
def _along(a_y: float, a_x: float, n_y: float, n_x: float) -> float:
    """Size of what `_across` takes from a vector: all of it where there is no normal."""
    b_y, b_x = _across(a_y, a_x, n_y, n_x)
    return float(np.sqrt((a_y - b_y) ** 2 + (a_x - b_x) ** 2))


@compiled
def _gather(cells: Cells, row: int, col: int, near_y: Single, near_x: Single) -> tuple[int, int]:
    """List the particles in a cell and around it, from its middle on.

    Return how many they are, filled up to lanes, and how much further on those of the cell stand in the list than among
    the sorted ones.
    """
    middle_y, middle_x = row * cells.size, col * cells.size
    length, own = 0, 0
    top, bottom, left, right = cells_around(cells, middle_y, middle_x, cells.size)
    for r in range(top, bottom + 1):
        first, last = row_of_cells(cells, r, left, right)
        own = length - first if r == row else own
        for k in range(first, last):
            near_y[length] = cells.y[k] - middle_y
            near_x[length] = cells.x[k] - middle_x
            length += 1
    while length % _LANES:
        near_y[length] = near_x[length] = _NOWHERE
        length += 1
    return length, own


@compiled
def _pair_sum(
    near_y: Single,
    near_x: Single,
    squares: Single,
    length: int,
    y: np.float32,
    x: np.float32,
    reach: np.float32,
    bend: Single,
) -> tuple[float, float]:
    """Sum what the far force leaves out of eq. (9), in single precision, and keep the squared distances."""
    one, nothing, tiny = np.float32(1.0), np.float32(0.0), np.float32(_SAME_SPOT)
    a, b, c = bend[0], bend[1], bend[2]
    f_y, f_x = nothing, nothing
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
def _two_nearest(squared: Single, bits: Bits, length: int) -> tuple[float, float]:
    """Least two of some squared distances, other than zero.

    The bits of positive numbers are in the order of the numbers, and whole numbers are compared many at once.
    """
    first = _INFINITE
    for j in range(length):
        here = bits[j]
        here = here if here > 0 else _INFINITE
        first = here if here < first else first
    second, ties = _INFINITE, 0
    for j in range(length):
        here = bits[j]
        ties += 1 if here == first else 0
        here = here if here > first else _INFINITE
        second = here if here < second else second
    bits[0], bits[1] = first, first if ties > 1 else second
    return squared[0], squared[1]


@compiled
def _two_nearest_of_many(cells: Cells, y: float, x: float, lonely: float) -> tuple[float, float]:
    """Squared distances of the two nearest particles as far away as anybody is looked for."""
    first, second = np.inf, np.inf
    top, bottom, left, right = cells_around(cells, y, x, lonely)
    for row in range(top, bottom + 1):
        start, end = row_of_cells(cells, row, left, right)
        for k in range(start, end):
            squared = (cells.y[k] - y) ** 2 + (cells.x[k] - x) ** 2
            if 0.0 < squared < first:
                first, second = squared, first
            elif 0.0 < squared < second:
                second = squared
    return first, second
