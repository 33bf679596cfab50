"""A step of a run in the plane: motion, deletion, insertion and annealing, and how scale and run come to their end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.interpolation import interpolate_field
from cpm_core.field.placed_charges import charge_radius_at, near_charges, placed_forces
from cpm_core.field.scale_field import ON_EDGE_FORCE, ScaleField
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.coverage import idle_steps_at, mark_covered
from cpm_core.model.equations import (
    FADED_STEPS,
    FINAL_DAMPING_STEPS,
    IDLE_STEPS,
    QUIET_STEPS,
    STILL_DISTANCE,
    creeping_range,
    damping_coefficient,
    equilibrium_epsilon,
    fast_speed,
    is_idle,
    is_quiet,
)
from cpm_core.model.interventions import start_scale
from cpm_core.model.measures import Energies, Forces, measure_energies
from cpm_core.model.plane.births import (
    examine_contacts,
    find_insertions,
    replace_particles,
    search_range,
    select_survivors,
)
from cpm_core.model.plane.enclosed_regions import MAX_PLANE_RESEEDINGS, reseeding_places
from cpm_core.model.plane.motion import (
    current_mesh_force,
    edge_contact_at,
    hold_at_barriers,
    is_at_rest,
    move_in_plane,
)
from cpm_core.model.plane.repulsion import build_plane_cells
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.starts import is_inside_image
from cpm_core.model.state import Particles
from cpm_core.numerics.types import Array, Index
from cpm_core.numerics.vectors import row_lengths
from cpm_core.parameters import Parameters

_UNDER_WAY_PATIENCE = 2
"""Factor by which a particle outside the coverage map that is fast comes to rest more slowly: it may have far to
go."""

_MAX_TRAVELLING_FRACTION = 0.25
"""Largest fraction of the particles that may be under way at the end of a coarser scale."""

_HOLDING_STRENGTH = 1.25
"""Edge strength, in multiples of the edge floor, that holds particles in any case."""

_OUTSIDE_COVERAGE = -1
"""Value for the idle steps of a particle outside the coverage map."""

_GATHERING_STEPS = 100
"""Steps without new coverage in which particles gather around a charge."""

_GATHERED_SPEED = 0.02
"""Speed under which a particle has gathered around a charge earlier [px / unit of time]."""


def idle_steps_of(state: PlaneState, scale_field: ScaleField, parameters: Parameters) -> Index:
    """Return the steps since there was new coverage around each particle, shape (N,), which bring it to rest.

    `state` is the one before the step, and `scale_field` includes the placed charges.
    """
    particles, fast = state.particles, fast_speed(parameters)
    # before the first coverage there is no limit
    under_way = state.idle // _UNDER_WAY_PATIENCE if state.coverage.size else 0
    idle = idle_steps_at(state.coverage, particles.position, state.step_of_scale, _OUTSIDE_COVERAGE)
    outside = np.flatnonzero(idle == _OUTSIDE_COVERAGE)
    idle[outside] = np.where((particles.velocity[outside] ** 2).sum(axis=1) > fast**2, under_way, state.idle)
    if state.charges:
        _let_gather(state, scale_field, idle)
    return idle


def is_travelling(state: PlaneState, parameters: Parameters) -> bool:
    """Return whether many particles are under way to their first edge, so that a coarser scale is not finished.

    A start far from all edges would else be handed on to the finest scale, where noise stops particles that have far
    to go.
    """
    idle = idle_steps_at(state.coverage, state.particles.position, state.step_of_scale, _OUTSIDE_COVERAGE)
    speed = row_lengths(state.particles.velocity[idle == _OUTSIDE_COVERAGE])
    return bool(np.count_nonzero(speed > fast_speed(parameters)) > _MAX_TRAVELLING_FRACTION * state.count)


def _let_gather(state: PlaneState, scale_field: ScaleField, idle: Index) -> None:
    """Let particles off the edges that gather around an attracting charge repel each other, then hold them, in `idle`.

    If the repulsion faded first, they would all move to one position, and all but one would be deleted.
    """
    near = np.flatnonzero(_is_attracted(state))
    strength, _, _ = edge_contact_at(state.particles.position[near], scale_field)
    near = near[strength < scale_field.floor]
    velocity = state.particles.velocity[near]
    slow = np.einsum("ni,ni->n", velocity, velocity) < _GATHERED_SPEED**2
    gathered = (idle[near] >= _GATHERING_STEPS) | (slow & (idle[near] >= FADED_STEPS))
    idle[near] = np.where(gathered, FINAL_DAMPING_STEPS, 0)


def _is_attracted(state: PlaneState) -> NDArray[np.bool_]:
    """Return a mask, shape (N,), of the particles within reach of a charge that attracts them."""
    attracting = state.placed[state.placed[:, -1] > 0.0]
    return near_charges(attracting, charge_radius_at(state.scale), state.particles.position)


def reseed_enclosed(state: PlaneState, scale_field: ScaleField) -> PlaneState | None:
    """Reseed next to enclosed boundaries that no particle has reached; None when none is missing.

    There is no reseeding in a run with erased particles, nor where a placed charge is stronger than an edge.
    """
    if state.reseedings == MAX_PLANE_RESEEDINGS or state.erased:
        return None
    places = reseeding_places(scale_field, drop_off_edge(state, scale_field).particles.position)
    if state.charges:
        force = placed_forces(state.placed, charge_radius_at(state.scale), places)
        places = places[(force**2).sum(axis=1) <= ON_EDGE_FORCE**2]
    if not len(places):
        return None
    state = drop_resting_off_edge(state, scale_field)  # else they would be reactivated in vain
    return replace(
        state,
        particles=state.particles.append(Particles.at_rest(places, state.next_identity)),
        next_identity=state.next_identity + len(places),
        reseedings=state.reseedings + 1,
        born=state.born + len(places),
        idle=0,
        quiet=0,
    )


def drop_resting_off_edge(state: PlaneState, scale_field: ScaleField) -> PlaneState:
    """Drop the particles at rest off the edge, if any particle has found an edge.

    In a hole of one or two pixels no particle has edge contact in the strict sense, but the edge around it is strong.
    Particles around an attracting charge stay.
    """
    position = state.particles.position
    strength, on_edge, _ = edge_contact_at(position, scale_field)
    found = on_edge | (strength >= _HOLDING_STRENGTH * scale_field.floor)
    if not found.any():
        return state
    found |= _is_attracted(state)
    if found.all():
        return state
    return replace(state, particles=state.particles.keep(found), deleted=state.deleted + int((~found).sum()))


def drop_off_edge(state: PlaneState, scale_field: ScaleField, keep_attracted: bool = False) -> PlaneState:
    """Drop the particles off the edge, since a finer scale begins with all seeds again.

    With `keep_attracted`, those within reach of an attracting charge stay.
    """
    _, found, _ = edge_contact_at(state.particles.position, scale_field)
    if keep_attracted:
        found |= _is_attracted(state)
    return replace(state, particles=state.particles.keep(found))


_FRONT_STEPS = 20
"""Steps since newly covered cells up to which a particle belongs to a front and searches at every step."""

_SEARCH_INTERVAL = 4
"""Steps between two searches of another particle."""

_LATE_INTERVAL = 2
"""Steps between two deletions and insertions once coverage hardly grows."""

_FADED_INTERVAL = 4
"""Steps between two deletions and insertions once no repulsion is left."""


def move_particles(
    state: PlaneState, idle: Index, scale_field: ScaleField, parameters: Parameters
) -> tuple[PlaneState, Array]:
    """Move the particles of a state and drop those that leave the image; also return how far each moved, shape (N,).

    `idle`, shape (N,), counts the steps since cells near each particle were newly covered.
    """
    particles, step = state.particles, state.step_of_scale
    mesh = current_mesh_force(state, idle, scale_field, parameters)
    moved, motion = move_in_plane(particles, idle, mesh, scale_field, parameters)
    moved, motion = hold_at_barriers(scale_field.barrier_map, particles, moved, motion)
    inside = np.flatnonzero(is_inside_image(moved.position, scale_field.shape))
    left = len(moved) - len(inside)
    if left:
        moved, motion = moved.select(inside), motion[inside]
    state = replace(
        state,
        particles=moved,
        mesh=mesh,
        step=state.step + 1,
        step_of_scale=step + 1,
        born=0,
        deleted=left,
        displacement=float(motion.mean()) if len(inside) else float("nan"),
        moving=int(np.count_nonzero(motion > STILL_DISTANCE)),
        epsilon=equilibrium_epsilon(moved.distance),
    )
    return state, motion


def insert_and_delete(
    state: PlaneState, motion: Array, repulsion_gone: bool, scale_field: ScaleField, parameters: Parameters
) -> PlaneState:
    """Delete and insert particles; late in a run this happens only at some steps.

    Annealing counts for each particle since cells near it were newly covered, as section 3.6 counts it for the run: a
    front on its way has as many young ones as at first, and where nothing new is found, births end.
    """
    every = _FADED_INTERVAL if repulsion_gone else _LATE_INTERVAL if state.idle >= IDLE_STEPS else 1
    if state.step % every:
        return replace(state, idle=state.idle + 1)
    particles, step, has_moved = state.particles, state.step_of_scale, motion > 0.0
    cells = build_plane_cells(particles.position, scale_field.shape, search_range(parameters))
    contact, close = examine_contacts(cells, has_moved, scale_field, parameters.d_min)
    kept = select_survivors(particles.position, contact.strength, parameters.d_min, close)
    if scale_field.area.size:
        kept &= particles.crept <= creeping_range(parameters) * 0.5**state.scale
    coverage, new = mark_covered(state.coverage, particles.position, contact.on_edge & kept, step)
    idle = idle_steps_at(coverage, particles.position, step, state.idle)
    # those of a front and young ones search always, the others by turns
    turn = (particles.identity + state.step // every) % _SEARCH_INTERVAL == 0
    looking = has_moved & (repulsion_gone | (idle < _FRONT_STEPS) | particles.young | turn)
    counts = np.arange(idle.max(initial=0) + 1)  # a power for each count, not for each particle
    insertion_range = np.asarray(parameters.d_max * parameters.annealing**counts, np.float64)[idle]
    births = find_insertions(contact, kept, looking, scale_field, insertion_range, parameters)
    born, deleted = len(births.position), len(kept) - int(np.count_nonzero(kept))
    if deleted or born:  # in the order of their cells: particles near in space are then near in memory
        stay = cells.order[kept[cells.order]] if deleted else np.arange(len(kept))
        particles = replace_particles(particles, stay, births, state.next_identity)
    return replace(
        state,
        particles=particles,
        next_identity=state.next_identity + born,
        born=born,
        deleted=state.deleted + deleted,
        coverage=coverage,
        idle=state.idle + 1 if is_idle(new, coverage.size) else 0,
    )


def check_end(
    state: PlaneState, scale_field: ScaleField, regions: AnyRegions | None, parameters: Parameters
) -> PlaneState:
    """End a scale or the run at equilibrium; else return the state."""
    quiet = is_quiet(state.epsilon, state.moving, state.born + state.deleted, state.count)
    if quiet or state.quiet:
        state = replace(state, quiet=state.quiet + 1 if quiet else 0)
    if state.scale > 0:
        # from a drawn start fronts have to come around corners; from everywhere only gaps are left
        patience = FADED_STEPS if scale_field.area.size else IDLE_STEPS
        done = state.idle >= patience and not is_travelling(state, parameters)
        if state.count == 0 or done:
            return start_scale(drop_off_edge(state, scale_field, keep_attracted=True), state.scale - 1, regions)
        return state
    if state.count == 0:
        return state.stop("all particles left the image")
    if state.quiet >= QUIET_STEPS:
        continued = reseed_enclosed(state, scale_field)
        if continued is not None:
            return continued
        reason = f"at rest: nothing has moved, appeared or vanished for {QUIET_STEPS} steps"
        return drop_resting_off_edge(state, scale_field).stop(reason, True)
    return state


def step_in_plane(
    state: PlaneState,
    field: ScaleField,
    regions: AnyRegions | None,
    parameters: Parameters,
) -> PlaneState:
    """Return the state after one time step, and after the end of its scale or its run if that has come.

    `field` includes the placed charges.
    """
    idle = idle_steps_of(state, field, parameters)
    repulsion_gone = not (idle < FADED_STEPS).any()
    state, motion = move_particles(state, idle, field, parameters)
    if len(state.particles):
        state = insert_and_delete(state, motion, repulsion_gone, field, parameters)
    return check_end(state, field, regions, parameters)


_NO_EDGES = np.zeros((2, 2, 5), np.float32)

_NO_EDGES[..., 0] = 1.0
"""Packed force field without edges, hence without friction; its Lorentz force is one, downwards."""


def plane_forces(
    state: PlaneState, scale_field: ScaleField, charged: ScaleField, parameters: Parameters, which: Index
) -> Forces:
    """Return the forces on the particles `which`, shape (M,), of a state as the next step begins.

    See `Engine.forces`.

    `scale_field` and `charged` are the fields of its scale without and with the placed charges.
    """
    particles, idle = state.particles, idle_steps_of(state, charged, parameters)
    chosen = particles.select(which)
    mesh = current_mesh_force(state, idle, scale_field, parameters)
    lorentz = parameters.w2 * interpolate_field(scale_field.lorentz, chosen.position)
    placed = parameters.w2 * interpolate_field(charged.lorentz, chosen.position) - lorentz
    idle_there = idle[which]
    apart, applied = (
        move_in_plane(particles, idle, mesh, field, parameters)[0].force[which, 0]
        for field in (replace(charged, force=lambda: _NO_EDGES), charged)
    )
    coulomb = np.where((idle_there < FADED_STEPS)[:, None], apart - (parameters.w2, 0.0), 0.0)
    late, kinds = np.unique(np.minimum(idle_there, FINAL_DAMPING_STEPS), return_inverse=True)
    beta = np.array([damping_coefficient(parameters.beta, int(steps)) for steps in late])[kinds]
    damped = -beta[:, None] * chosen.velocity
    at_rest = is_at_rest(chosen, idle_there)
    applied[at_rest], damped[at_rest] = 0.0, 0.0
    return Forces(coulomb, lorentz, placed, applied - (coulomb + lorentz + placed), damped)


def plane_energies(state: PlaneState, scale_field: ScaleField, parameters: Parameters) -> Energies:
    """Return the energies of a state with its placed charges; `scale_field` is without them. See `Engine.energies`."""
    return measure_energies(state, scale_field, parameters, (1.0, 1.0), parameters.d_min + parameters.d_max)
