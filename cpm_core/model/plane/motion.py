"""The motion of all particles of the plane in one time step: the laws of `equations`, applied in one compiled loop.

A step skips a particle that is at rest where no cell has been newly covered for long: nothing that could move it
changes, until cells near it are newly covered or an intervention reactivates the run. A particle whose step would cross
a barrier slides along it, or stays where it is.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.interpolation import (
    EDGE_STRENGTH,
    FORCE_COL,
    FORCE_ROW,
    GRADIENT_COL,
    GRADIENT_ROW,
    interpolate_component,
    pixel_before,
)
from cpm_core.field.scale_field import ON_EDGE_FORCE, ScaleField
from cpm_core.image.regions import BarrierMap, crosses_barrier
from cpm_core.model.coverage import cell_of
from cpm_core.model.equations import (
    FADED_STEPS,
    MAX_TRAVEL,
    advance_coordinate,
    coulomb_scale,
    damped_motion,
    is_stuck,
    repulsion_left,
)
from cpm_core.model.plane.repulsion import (
    NO_MESH,
    VECTOR_LANES,
    Bits,
    MeshForce,
    PlaneCells,
    build_plane_cells,
    count_mesh_nodes,
    gather_near,
    mesh_force,
    mesh_force_at,
    pair_sums,
    two_nearest_of_many,
)
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.state import HISTORY_STEPS, Particles
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.segments import segments_meet, side_of_line
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.parameters import Parameters


@compiled
def is_on_edge(squared: float, strength: float, floor: float) -> bool:
    """Return whether a particle is on an edge: a weak Lorentz force, and an edge strength of at least `floor`.

    `squared` is the squared length of the interpolated Lorentz force, which is of unit size away from edges and below
    the gate on an edge.
    """
    return squared < ON_EDGE_FORCE**2 and strength >= floor


def edge_contact_at(positions: Array, scale_field: ScaleField) -> tuple[Array, Mask, Array]:
    """Return edge strength, edge contact and image gradient at particles, shape (N, 2)."""
    count = len(positions)
    strength, on_edge, normal = np.empty(count), np.empty(count, np.bool_), np.empty((count, 2))
    _contact_at(scale_field.packed, scale_field.floor, positions, strength, on_edge, normal)
    return strength, on_edge, normal


@compiled
def _contact_at(packed: Single, floor: float, position: Array, strength: Array, on_edge: Mask, normal: Array) -> None:
    for i in range(len(position)):
        found = edge_state_at(packed, position[i, 0], position[i, 1], floor)
        strength[i], on_edge[i], normal[i, 0], normal[i, 1] = found


@compiled
def edge_state_at(packed: Single, y: float, x: float, floor: float) -> tuple[float, bool, float, float]:
    """Return the edge strength at a position, whether a particle there is on an edge, and the image gradient."""
    place = pixel_before(packed, y, x)
    f_y, f_x, strength = (
        interpolate_component(packed, FORCE_ROW, place),
        interpolate_component(packed, FORCE_COL, place),
        interpolate_component(packed, EDGE_STRENGTH, place),
    )
    on_edge = is_on_edge(f_y**2 + f_x**2, strength, floor)
    return (
        strength,
        on_edge,
        interpolate_component(packed, GRADIENT_ROW, place),
        interpolate_component(packed, GRADIENT_COL, place),
    )


PAIR_REACH = 2.0
"""Reach of the pairs where a mesh carries the rest, in d_min + d_max."""

NEIGHBOR_RANGE = 8.0
"""Largest distance at which the two nearest neighbors are searched, in d_min + d_max."""

REST_SPEED = 5e-4
"""Speed under which a particle is at rest where no cell has been newly covered for long [px / unit of time]."""


class MotionLaw(NamedTuple):
    """The parameters of motion.

    Attributes
    ----------
    w1, w2, d_min, dt : float
        Weights of eq. (12), spacing, time step.
    neighbor_range : float
        `NEIGHBOR_RANGE` [px].
    floor : float
        Least edge strength for edge contact.
    """

    w1: float
    w2: float
    d_min: float
    dt: float
    neighbor_range: float
    floor: float


def is_at_rest(particles: Particles, idle: Index) -> Mask:
    """Return a mask, shape (N,), of the particles that the next step skips."""
    slow = np.einsum("ni,ni->n", particles.velocity, particles.velocity) < REST_SPEED**2
    return slow & (idle >= FADED_STEPS) & ~particles.young


_Repulsion = tuple[Array, Single, Bits, Array]
"""The Coulomb force, and room for the particles near those of a cell, for the bits of the last of its rows, and for
their sums; Numba would compile for each kernel what makes an array."""

Four = tuple[float, float, float, float]
"""Four numbers, such as a damped series or the history of two forces."""

_PAIRS_PER_NODE = 28
"""Pairs that are summed in the time of one node of the padded mesh, divided by the steps for which the mesh is used."""

_MOVED_PER_THREAD = 800
"""Particles from which a second thread makes the step faster, while some are repelled."""

_LATE_MOVED_PER_THREAD = 4000
"""Particles from which a second thread makes the step faster later."""


MESH_INTERVAL = 4
"""Steps for which the force on a mesh is used: during these, particles move by a small part of its reach."""


def current_mesh_force(state: PlaneState, idle: Index, scale_field: ScaleField, parameters: Parameters) -> MeshForce:
    """Return the mesh of the step after a state: the present one, or a new one every `MESH_INTERVAL` steps.

    There is none where summing all pairs is faster, or the repulsion has faded for all particles. `idle`, shape (N,),
    are the steps since cells around each particle were newly covered.
    """
    if state.step_of_scale % MESH_INTERVAL and state.mesh is not None:
        return state.mesh
    reach = PAIR_REACH * (parameters.d_min + parameters.d_max)
    repelled = np.count_nonzero(idle < FADED_STEPS)
    if repelled * state.count < _PAIRS_PER_NODE * count_mesh_nodes(scale_field.shape, reach):
        return NO_MESH
    return mesh_force(state.particles.position, scale_field.shape, reach)


def move_in_plane(
    particles: Particles, idle: Index, mesh: MeshForce, scale_field: ScaleField, parameters: Parameters
) -> tuple[Particles, Array]:
    """Move all particles by one time step; return them, and the distance that each has moved [px], shape (N,).

    `idle`, shape (N,), are the steps since cells around each were newly covered, `mesh` is the smooth part of the
    Coulomb force. The parameters act at once. The force on a particle at rest is that of its last step.
    """
    size = mesh.reach if np.isfinite(mesh.reach) else float(max(scale_field.shape) + 1)
    cells = build_plane_cells(particles.position, scale_field.shape, size)
    near = NEIGHBOR_RANGE * (parameters.d_min + parameters.d_max)
    law = MotionLaw(parameters.w1, parameters.w2, parameters.d_min, parameters.time_step, near, scale_field.floor)
    damped = damped_motion(parameters.beta, parameters.time_step)
    before = particles.velocity, particles.force, particles.distance, particles.crept
    position, velocity, force, distance = map(np.empty_like, (particles.position, *before[:3]))
    crept, motion = np.empty((2, len(particles)))
    moved = position, velocity, force, distance, crept, motion
    work = partial(_move_sorted, cells, scale_field.packed, scale_field.area, idle, mesh, damped, law, before, moved)

    def move_some(first: int, last: int) -> None:
        room = len(particles) + VECTOR_LANES
        near, coulomb = np.empty((3, room), np.float32), np.zeros((last - first, 2))
        work((coulomb, near, near[2].view(np.int32), np.empty((room, 4))), first, last)

    some = _MOVED_PER_THREAD if (idle < FADED_STEPS).any() else _LATE_MOVED_PER_THREAD
    run_in_parallel(move_some, len(particles), some)
    return Particles(position, velocity, force, distance, particles.identity, crept), motion


READ_AHEAD_COUNT = 64
"""Number of particles whose field is read ahead."""


@compiled
def prefetch_field(packed: Single, cells: PlaneCells, first: int, last: int, anything: Array) -> None:
    """Read the field at the next of the sorted particles, so that it is near when they need it.

    Memory answers many independent requests as fast as one, whereas a computation with each value would make a request
    wait for the one before. The values go into `anything`, shape (N,), which is overwritten later.
    """
    for k in range(first, min(first + READ_AHEAD_COUNT, last)):
        row, col, _, _ = pixel_before(packed, cells.y[k], cells.x[k])
        upper = packed[row, col, 0] + packed[row, col + 1, 4]
        lower = packed[row + 1, col, 0] + packed[row + 1, col + 1, 4]
        anything[cells.order[k]] = upper + lower


@compiled
def _move_sorted(
    cells: PlaneCells,
    packed: Single,
    area: Mask,
    idle: Index,
    mesh: MeshForce,
    damped: Array,
    law: MotionLaw,
    before: tuple[Array, Array, Array, Array],
    after: tuple[Array, Array, Array, Array, Array, Array],
    repulsion: _Repulsion,
    first: int,
    last: int,
) -> None:
    """Move some of the sorted particles."""
    velocity, force, distance, crept = before
    to_position, to_velocity, to_force, to_distance, to_crept, motion = after
    _write_repulsion(cells, idle, mesh, law, repulsion, first, last)
    coulomb = repulsion[0]
    for k in range(first, last):
        if (k - first) % READ_AHEAD_COUNT == 0 and idle[
            cells.order[k]
        ] < FADED_STEPS:  # later hardly any particle moves
            prefetch_field(packed, cells, k, last, motion)
        i, y, x = cells.order[k], cells.y[k], cells.x[k]
        v_y, v_x = velocity[i, 0], velocity[i, 1]
        to_y, to_x = y, x
        history = (force[i, 0, 0], force[i, 0, 1], force[i, 1, 0], force[i, 1, 1])
        if idle[i] >= FADED_STEPS and v_y**2 + v_x**2 < REST_SPEED**2 and not np.isnan(distance[i, HISTORY_STEPS - 1]):
            v_y, v_x = 0.0, 0.0
        else:
            late = min(idle[i], len(damped) - 1)
            series = (damped[late, 0], damped[late, 1], damped[late, 2], damped[late, 3])
            c_y, c_x = coulomb[k - first, 0], coulomb[k - first, 1]
            to_y, to_x, v_y, v_x, history = _step_particle(
                packed, law, idle[i], series, y, x, v_y, v_x, c_y, c_x, history
            )
        to_position[i, 0], to_position[i, 1], to_velocity[i, 0], to_velocity[i, 1] = to_y, to_x, v_y, v_x
        to_force[i, 0, 0], to_force[i, 0, 1], to_force[i, 1, 0], to_force[i, 1, 1] = history
        to_distance[i, 1], to_distance[i, 2], to_distance[i, 3] = distance[i, 0], distance[i, 1], distance[i, 2]
        to_distance[i, 0] = np.sqrt(to_y**2 + to_x**2)
        motion[i] = np.sqrt((to_y - y) ** 2 + (to_x - x) ** 2)
        to_crept[i] = 0.0
        if not _is_inside(area, to_y, to_x):
            to_crept[i] = crept[i] + _way_along_edge(packed, law.floor, y, x, to_y - y, to_x - x)


@compiled
def _way_along_edge(packed: Single, floor: float, y: float, x: float, down: float, right: float) -> float:
    """Return how far a move from a position goes along an edge that is strong enough; 0 off the edges."""
    _, on_edge, n_y, n_x = edge_state_at(packed, y, x, floor)
    if not on_edge:
        return 0.0
    size = max(np.sqrt(n_y**2 + n_x**2), 1e-30)
    return _size_along(down, right, n_y / size, n_x / size)


@compiled
def _is_inside(area: Mask, y: float, x: float) -> bool:
    """Return whether a position lies in an area; an empty one is everywhere."""
    rows, cols = area.shape
    return rows == 0 or bool(area[min(max(int(y + 0.5), 0), rows - 1), min(max(int(x + 0.5), 0), cols - 1)])


@compiled
def _write_repulsion(
    cells: PlaneCells, idle: Index, mesh: MeshForce, law: MotionLaw, repulsion: _Repulsion, first: int, last: int
) -> None:
    """Write the normalized Coulomb force on some of the sorted particles, shape (`last` - `first`, 2), cell by cell."""
    smooth, softening = mesh.force, mesh.softening  # taking an array out of a tuple is too slow for every particle
    coulomb, near, bits, sums = repulsion
    reach, end, listed, length, own = np.float32(mesh.reach), first, -1, 0, 0
    while end < last:
        k = end
        if repulsion_left(idle[cells.order[k]]) == 0.0:
            end += 1
            continue
        row, col = cell_of(cells.y[k], cells.size, cells.rows), cell_of(cells.x[k], cells.size, cells.cols)
        cell = row * cells.cols + col
        if cell != listed:
            listed = cell
            length, own = gather_near(cells, row, col, near)
        beyond = min(cells.start[cell + 1], last)
        while end < beyond and repulsion_left(idle[cells.order[end]]) > 0.0:
            end += 1
        pair_sums(near, bits, length, own + k, own + end, reach, softening, sums)
        for n in range(k, end):
            y, x, left = cells.y[n], cells.x[n], repulsion_left(idle[cells.order[n]])
            c_y, c_x, one, other = sums[n - k, 0], sums[n - k, 1], sums[n - k, 2], sums[n - k, 3]
            if len(smooth):
                far_y, far_x = mesh_force_at(smooth, (y - mesh.first[0]) / mesh.pitch, (x - mesh.first[1]) / mesh.pitch)
                c_y, c_x = c_y + far_y, c_x + far_x
            if other > cells.size**2:  # a particle outside the list may be nearer
                one, other = two_nearest_of_many(cells, y, x, law.neighbor_range)
            spacing = 0.5 * (min(np.sqrt(one), law.neighbor_range) + min(np.sqrt(other), law.neighbor_range))
            scale = coulomb_scale(np.sqrt(c_y**2 + c_x**2), spacing, law.d_min)
            coulomb[n - first, 0], coulomb[n - first, 1] = left * (c_y * scale), left * (c_x * scale)


@compiled
def _step_particle(
    packed: Single,
    law: MotionLaw,
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
    """Return the particle after the step of eq. (14)-(15), by the total force of eq. (12) with Coulomb force c."""
    last_y, last_x, old_y, old_x = history
    place = pixel_before(packed, y, x)
    l_y, l_x = interpolate_component(packed, FORCE_ROW, place), interpolate_component(packed, FORCE_COL, place)
    f_y, f_x = law.w1 * c_y + law.w2 * l_y, law.w1 * c_x + law.w2 * l_x
    if l_y**2 + l_x**2 < ON_EDGE_FORCE**2:
        n_y, n_x = (
            interpolate_component(packed, GRADIENT_ROW, place),
            interpolate_component(packed, GRADIENT_COL, place),
        )
        size = max(np.sqrt(n_y**2 + n_x**2), 1e-30)
        n_y, n_x = n_y / size, n_x / size
        if is_stuck(_size_along(f_y, f_x, n_y, n_x), _size_along(v_y, v_x, n_y, n_x), law.w1, idle):
            f_y, f_x = _part_across(f_y, f_x, n_y, n_x)
            v_y, v_x = _part_across(v_y, v_x, n_y, n_x)
            last_y, last_x = _part_across(last_y, last_x, n_y, n_x)
            old_y, old_x = _part_across(old_y, old_x, n_y, n_x)
    to_y, v_y = advance_coordinate(y, v_y, f_y, last_y, old_y, law.dt, series)
    to_x, v_x = advance_coordinate(x, v_x, f_x, last_x, old_x, law.dt, series)
    farthest = MAX_TRAVEL * law.d_min
    kept = farthest / max(farthest, np.sqrt((to_y - y) ** 2 + (to_x - x) ** 2))
    to_y, to_x = y + kept * (to_y - y), x + kept * (to_x - x)
    kept = farthest / max(farthest, law.dt * np.sqrt(v_y**2 + v_x**2))
    v_y, v_x = kept * v_y, kept * v_x
    return to_y, to_x, v_y, v_x, (f_y, f_x, last_y, last_x)


@compiled
def _part_across(a_y: float, a_x: float, n_y: float, n_x: float) -> tuple[float, float]:
    """Return the part of a vector along the unit vector n, the normal of an edge: the part across the edge."""
    size = a_y * n_y + a_x * n_x
    return size * n_y, size * n_x


@compiled
def _size_along(a_y: float, a_x: float, n_y: float, n_x: float) -> float:
    """Return the size of the part that `_part_across` removes from a vector; the whole one where there is no normal."""
    b_y, b_x = _part_across(a_y, a_x, n_y, n_x)
    return float(np.sqrt((a_y - b_y) ** 2 + (a_x - b_x) ** 2))


def hold_at_barriers(
    barrier_map: BarrierMap, before: Particles, after: Particles, motion: Array
) -> tuple[Particles, Array]:
    """Hold particles back where they cross a barrier or the boundary of a region of interest.

    Such a particle keeps the part of its step and of its velocity that is along the barrier, if this part crosses no
    other barrier; otherwise it stays where it was before, at rest. Returns the particles, and the distance that each
    has moved, which was `motion`, shape (N,).
    """
    blocked = barrier_map.is_crossed_by(before.position, after.position)
    if not blocked.any():
        return after, motion
    position, velocity, distance = after.position.copy(), after.velocity.copy(), after.distance.copy()
    _slide_along_barriers(barrier_map, np.flatnonzero(blocked), before.position, position, velocity)
    distance[:, 0] = np.linalg.norm(position, axis=1)
    motion = np.linalg.norm(position - before.position, axis=1)
    return replace(after, position=position, velocity=velocity, distance=distance), motion


@compiled
def _slide_along_barriers(
    barrier_map: BarrierMap, blocked: NDArray[np.int64], before: Array, position: Array, velocity: Array
) -> None:
    """Let blocked particles slide along the barrier, in place."""
    for n in range(len(blocked)):
        i = blocked[n]
        first, barrier = np.inf, -1
        for s in range(len(barrier_map.segments)):
            if segments_meet(barrier_map.segments[s], before[i], position[i]):
                here = side_of_line(barrier_map.segments[s, :2], barrier_map.segments[s, 2:], before[i])
                there = side_of_line(barrier_map.segments[s, :2], barrier_map.segments[s, 2:], position[i])
                way = here / (here - there) if here != there else 0.0
                if way < first:
                    first, barrier = way, s
        row = barrier_map.segments[barrier, 2] - barrier_map.segments[barrier, 0]
        col = barrier_map.segments[barrier, 3] - barrier_map.segments[barrier, 1]
        squared = row**2 + col**2
        slide = ((position[i, 0] - before[i, 0]) * row + (position[i, 1] - before[i, 1]) * col) / squared
        speed = (velocity[i, 0] * row + velocity[i, 1] * col) / squared
        position[i, 0], position[i, 1] = before[i, 0] + row * slide, before[i, 1] + col * slide
        velocity[i, 0], velocity[i, 1] = row * speed, col * speed
        if crosses_barrier(barrier_map, before[i], position[i]):
            position[i, 0], position[i, 1] = before[i, 0], before[i, 1]
            velocity[i, 0], velocity[i, 1] = 0.0, 0.0
