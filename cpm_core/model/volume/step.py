"""A step of a run in a volume: motion, deletion and insertion of the particles that are awake, and the end of a scale.

A particle sleeps once nothing new has been covered near it for some steps, that is, no cell and side where no surface
had been found before. Particles inserted where the surface is covered already reactivate no others; else a crowd on one
surface would keep itself moving forever. A particle that has found no surface is deleted when it has been slow for
long: it hovers between others. So is one that has crept farther than the creeping range.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cpm_core.field.placed_charges import ChargesAtScale, charge_radius_at
from cpm_core.field.volume_field import VolumeField
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.coverage import SurfaceCoverage, cover_surfaces, no_surface_coverage
from cpm_core.model.equations import (
    STILL_DISTANCE,
    creeping_range,
    damping_coefficient,
    equilibrium_epsilon,
    fast_speed,
)
from cpm_core.model.interventions import start_scale
from cpm_core.model.measures import Energies, Forces, measure_energies
from cpm_core.model.volume.births import (
    NEW_PARTICLE_ROOM,
    VolumeBirths,
    find_surface_insertions,
    select_surface_survivors,
)
from cpm_core.model.volume.completion import drop_off_surface, reseed_surface
from cpm_core.model.volume.motion import (
    MIN_CELL_SIDE,
    REPULSION_REACH,
    VolumeCells,
    act_on_each_other,
    build_volume_cells,
    find_near,
    force_parts,
    hold_at_walls,
    move_in_volume,
    near_buffer,
)
from cpm_core.model.volume.state import VolumeParticles, VolumeState
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.numerics.vectors import Vector, row_lengths, row_of
from cpm_core.parameters import Parameters

_AWAKE_STEPS = 12
"""Steps without new coverage after which a particle on a surface sleeps."""

_SLOW_STEPS = 60
"""Slow steps after which a free particle is deleted."""

_COVERED_START_AGE = 6
"""Steps that a particle inserted on covered surface counts as having been awake already."""

_REACTIVATION_DISTANCE = 3.0
"""Distance from new coverage up to which others are reactivated, in the least distances of new particles."""

_QUIET_NEW_FRACTION = 0.0005
"""Largest fraction of the particles that may cover something new in a quiet step."""

_QUIET_AWAKE_FRACTION = 0.02
"""Largest fraction of the particles that may be awake in a quiet step."""

_LONG_IDLE_STEPS = 15
"""Steps without new coverage after which any number may be awake in a quiet step."""


def step_particles(state: VolumeState, field: VolumeField, parameters: Parameters) -> VolumeState:
    """Return the state after one time step, before it is decided whether the run continues."""
    before, step, extent, d_min = state.particles, state.step_of_scale, field.extent, parameters.d_min
    cells = repulsion_cells(before, field, d_min)
    idle, awake = find_awake(before, step)
    placed = ChargesAtScale(state.placed, charge_radius_at(state.scale))
    after, motion = move_in_volume(before, cells.order[awake[cells.order]], cells, idle, field, parameters, placed)
    after.velocity[~awake] = 0.0
    creeping = before.on_surface & after.on_surface & (before.crept > 0.0)  # those of the start do not
    after = replace(after, crept=before.crept + creeping * motion)
    farthest = creeping_range(parameters) * 0.5**state.scale
    stays = _is_inside(after.position, extent, state.pitch) & (before.on_surface | (idle < _SLOW_STEPS))
    stays &= after.crept <= farthest
    if field.walls is not None:
        after = hold_at_walls(field.walls, before, after)
    fast = row_lengths(after.velocity) > fast_speed(parameters)
    in_flight = ~after.on_surface & fast & (step < 2.0 * max(extent) + state.reactivated)
    arrived = after.on_surface & ~before.on_surface
    after = after.reactivate(in_flight, step + 1)
    particles, stay, cells = _delete_close(after, stays, awake, cells, extent, d_min)
    awake, arrived = awake[stay], arrived[stay]
    deleted = len(before) - len(particles)
    d_max = state.annealed * parameters.d_max
    turn = cells.order[awake[cells.order]]
    births = find_surface_insertions(particles, cells, turn, field, d_min, d_max, placed, farthest)
    particles, coverage, new = _insert_particles(state, particles, births, cells, arrived, d_min)
    few = new <= max(1.0, _QUIET_NEW_FRACTION * len(particles))
    idle_steps = state.idle + 1 if few else 0
    most = min(max(3.0, _QUIET_AWAKE_FRACTION * len(particles)), len(particles) - 1.0)  # of two, both are under way
    still = bool(np.count_nonzero(awake) <= most or (idle_steps > _LONG_IDLE_STEPS and not in_flight.any()))
    return replace(
        state,
        particles=particles,
        coverage=coverage,
        annealed=state.annealed * parameters.annealing,
        step=state.step + 1,
        step_of_scale=step + 1,
        next_identity=state.next_identity + len(births.position),
        born=len(births.position),
        deleted=deleted,
        epsilon=equilibrium_epsilon(after.distance),
        displacement=float(motion.mean()) if len(motion) else float("nan"),
        moving=int(np.count_nonzero(motion > STILL_DISTANCE)),
        idle=idle_steps,
        quiet=state.quiet + 1 if few and still else 0,
    )


def repulsion_cells(particles: VolumeParticles, field: VolumeField, d_min: float) -> VolumeCells:
    """Sort the particles into cells, to find those that repel each other."""
    return build_volume_cells(particles.position, field.extent, max(REPULSION_REACH * d_min, MIN_CELL_SIDE))


def find_awake(particles: VolumeParticles, step: int) -> tuple[Index, Mask]:
    """Return the steps since something new was covered near each particle, and which are awake; both of shape (N,)."""
    idle = np.maximum(step - particles.reactivated_at, 0)
    return idle, (idle < _AWAKE_STEPS) | (~particles.on_surface & (idle < _SLOW_STEPS))


def _is_inside(position: Array, extent: Vector, pitch: Vector) -> Mask:
    """Return a mask of the particles in the volume, between the centers of the outermost voxels."""
    last = np.array(extent) - np.array(pitch)
    within: Mask = (position >= 0.0) & (position <= last)
    return within[:, 0] & within[:, 1] & within[:, 2]  # much faster than along the axis


def _delete_close(
    particles: VolumeParticles, stays: Mask, awake: Mask, cells: VolumeCells, extent: Vector, d_min: float
) -> tuple[VolumeParticles, Index, VolumeCells]:
    """Return the particles that stay and are not too near to others, their indices, and their cells."""
    stay = np.flatnonzero(stays)
    particles = particles if stays.all() else particles.select(stay)
    cells = build_volume_cells(particles.position, extent, cells.size)
    kept = select_surface_survivors(particles, cells, np.flatnonzero(awake[stay]), d_min)
    if kept.all():
        return particles, stay, cells
    left = cells.order[kept[cells.order]]  # in the order of their cells: near in space, near in memory
    particles = particles.select(left)
    return particles, stay[left], build_volume_cells(particles.position, extent, cells.size)


def _insert_particles(
    state: VolumeState,
    particles: VolumeParticles,
    births: VolumeBirths,
    cells: VolumeCells,
    arrived: Mask,
    d_min: float,
) -> tuple[VolumeParticles, SurfaceCoverage, int]:
    """Insert new particles and reactivate those near new coverage; return also coverage and how many are new in it."""
    coverage, on_surface, step = state.coverage, particles.on_surface, state.step_of_scale + 1
    if coverage.side != d_min:  # the coverage of the present particles, after all were reactivated
        coverage, _ = cover_surfaces(
            no_surface_coverage(d_min), particles.position[on_surface], particles.normal[on_surface]
        )
    some = np.flatnonzero(arrived)
    places = np.concatenate([particles.position[some], births.position])
    coverage, fresh = cover_surfaces(coverage, places, np.concatenate([particles.normal[some], births.normal]))
    woken = np.zeros(len(particles), bool)
    _mark_near(cells, places[fresh], _REACTIVATION_DISTANCE * NEW_PARTICLE_ROOM * d_min, woken)
    particles = particles.reactivate(woken, step)
    if len(births.position):
        reactivated_at = np.where(fresh[len(some) :], step, step - _COVERED_START_AGE)
        more = VolumeParticles.at_rest_on_surfaces(
            births.position, state.next_identity, births.normal, births.strength, births.crept, reactivated_at
        )
        particles = particles.append(more)
    return particles, coverage, int(np.count_nonzero(fresh))


@compiled
def _mark_near(cells: VolumeCells, places: Array, reach: float, woken: Mask) -> None:
    """Mark the particles that are within reach of places."""
    found = near_buffer(cells)
    for q in range(len(places)):
        for n in range(find_near(cells, row_of(places, q), reach, found)):
            woken[cells.order[found[n]]] = True


_QUIET_TO_RESEED = 2
"""Consecutive quiet steps after which particles are reseeded or a coarser scale ends."""

_QUIET_TO_END = 4
"""Consecutive quiet steps that end the run."""


def step_in_volume(
    state: VolumeState, field: VolumeField, regions: AnyRegions | None, parameters: Parameters
) -> VolumeState:
    """Return the state after one time step, and after the end of its scale or its run if that has come."""
    state = step_particles(state, field, parameters)
    if not state.count:
        return state.stop("all particles left the volume")
    if state.scale > 0:
        if state.quiet < _QUIET_TO_RESEED:
            return state
        return start_scale(drop_off_surface(state, field), state.scale - 1, regions)
    if state.quiet >= _QUIET_TO_RESEED:
        continued = reseed_surface(state, field, parameters.d_min, creeping_range(parameters))
        if continued is not None:
            return continued
    if state.quiet >= _QUIET_TO_END:
        return drop_off_surface(state, field).stop("at rest: no particle finds anything new", True)
    return state


def volume_forces(
    state: VolumeState, field: VolumeField, _charged: VolumeField, parameters: Parameters, which: Index
) -> Forces:
    """Return the forces on the particles `which`, shape (M,), of a state as the next step begins.

    See `Engine.forces`.
    """
    charges = ChargesAtScale(state.placed, charge_radius_at(state.scale))
    idle, awake = find_awake(state.particles, state.step_of_scale)
    coulomb, lorentz, placed, friction = force_parts(
        state.particles,
        which,
        repulsion_cells(state.particles, field, parameters.d_min),
        idle,
        field,
        parameters,
        charges,
    )
    beta = np.array([damping_coefficient(parameters.beta, int(steps)) for steps in idle[which]])
    damped = -beta[:, None] * state.particles.velocity[which]
    asleep = ~awake[which]
    friction[asleep] = -(coulomb + lorentz + placed)[asleep]
    damped[asleep] = 0.0
    return Forces(coulomb, lorentz, placed, friction, damped)


def volume_energies(state: VolumeState, field: VolumeField, parameters: Parameters) -> Energies:
    """Return the energies of a state with its placed charges; `field` is without them. See `Engine.energies`."""
    rule = act_on_each_other(state.particles.normal, state.particles.on_surface)
    return measure_energies(state, field, parameters, field.pitch, REPULSION_REACH * parameters.d_min, rule)
