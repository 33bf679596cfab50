"""A step of a run in a volume: motion, deletion and insertion of the particles that are awake, and the end of a scale.

A particle sleeps once no new ground has been found near it for some steps: a cell and side where no surface had been
found before. What is inserted on old ground wakes nobody; else a crowd on one surface would stir itself up for ever. A
particle that has found no surface goes when it has been slow for long: it hovers between others.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cpm_core.field.interpolation import interpolate
from cpm_core.field.placed_charges import Placed, placed_potential, radius_at
from cpm_core.field.volume_field import VolumeField
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.coverage import SurfaceCoverage, cover_surfaces, no_surface
from cpm_core.model.equations import STILL, damping, epsilon, fast_speed
from cpm_core.model.interventions import start_scale
from cpm_core.model.measures import PAIR, Energies, Forces, kinetic_energy
from cpm_core.model.state import Particles, SpaceState, State, SurfaceContact
from cpm_core.model.volume.births import ROOM, Births, insertion, thinned
from cpm_core.model.volume.completion import drop_unseated, reseed_surface
from cpm_core.model.volume.motion import (
    LEAST_CELL,
    REACH,
    Cells,
    build_cells,
    held_back,
    move,
    near,
    on_one_sheet,
    parts_of_force,
    room_for,
)
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.numerics.vectors import Vector, difference, dot, lengths, row_of
from cpm_core.parameters import Parameters

_AWAKE, _PATIENCE = 12, 60
"""Steps without new ground after which a seated particle sleeps, and slow ones after which a free particle goes."""

_OLD_GROUND = 6
"""Steps that a particle inserted on old ground has been awake already."""

_WOKEN = 3.0
"""Distance from new ground up to which others wake, in the least distances of new particles."""

_FEW_NEW, _FEW_AWAKE, _LONG = 0.0005, 0.02, 15
"""Fractions of the particles that may find new ground in a quiet step, and be awake in it, unless nothing new has been
found for so many steps."""


def moved_on(state: State, field: VolumeField, parameters: Parameters) -> State:
    """The state after one time step, before it is decided whether the run continues."""
    space, step = state.space, state.step_of_scale
    assert space is not None
    extent, d_min = field.extent, parameters.d_min
    before = state.particles
    cells = cells_of(before, field, d_min)
    idle, awake = rested(before, step)
    placed = Placed(state.placed, radius_at(state.scale))
    moved = move(before, cells.order[awake[cells.order]], cells, idle, field, parameters, placed)
    after, motion = moved.particles, moved.motion
    after.velocity[~awake] = 0.0
    stays = _inside(after.position, extent, space) & (before.on_surface.seated | (idle < _PATIENCE))
    if field.walls is not None:
        after = held_back(field.walls, before, after)
    fast = lengths(after.velocity) > fast_speed(parameters)
    flying = ~after.on_surface.seated & fast & (step < 2.0 * max(extent) + state.reactivated)
    arrived = after.on_surface.seated & ~before.on_surface.seated
    after = replace(after, contact=after.on_surface.woken_at(step + 1, flying))
    particles, stay, cells = _thinned(after, stays, awake, cells, extent, d_min)
    awake, arrived = awake[stay], arrived[stay]
    deleted = len(before) - len(particles)
    d_max = state.annealed * parameters.d_max
    births = insertion(particles, cells, cells.order[awake[cells.order]], field, d_min, d_max, placed)
    particles, covered, new = _joined(state, particles, births, cells, arrived, d_min)
    few = new <= max(1.0, _FEW_NEW * len(particles))
    idle_steps = state.idle + 1 if few else 0
    most = min(max(3.0, _FEW_AWAKE * len(particles)), len(particles) - 1.0)  # of two, both are under way
    still = bool(np.count_nonzero(awake) <= most or (idle_steps > _LONG and not flying.any()))
    return replace(
        state,
        particles=particles,
        space=replace(space, covered=covered),
        annealed=state.annealed * parameters.annealing,
        step=state.step + 1,
        step_of_scale=step + 1,
        next_identity=state.next_identity + len(births.position),
        born=len(births.position),
        deleted=deleted,
        epsilon=epsilon(after.distance),
        displacement=float(motion.mean()) if len(motion) else float("nan"),
        moving=int(np.count_nonzero(motion > STILL)),
        idle=idle_steps,
        quiet=state.quiet + 1 if few and still else 0,
    )


def cells_of(particles: Particles, field: VolumeField, d_min: float) -> Cells:
    """The particles in cells, for the search for those that repel each other."""
    return build_cells(particles.position, field.extent, max(REACH * d_min, LEAST_CELL))


def rested(particles: Particles, step: int) -> tuple[Index, Mask]:
    """Steps since new ground was found near each particle, and which are awake."""
    contact = particles.on_surface
    idle = np.maximum(step - contact.woken, 0)
    return idle, (idle < _AWAKE) | (~contact.seated & (idle < _PATIENCE))


def _inside(position: Array, extent: Vector, space: SpaceState) -> Mask:
    """Which particles lie in the volume, between the centers of the outermost voxels."""
    last = np.array(extent) - np.array(space.pitch)
    within: Mask = (position >= 0.0) & (position <= last)
    return within[:, 0] & within[:, 1] & within[:, 2]  # much faster than along the axis


def _thinned(
    particles: Particles, stays: Mask, awake: Mask, cells: Cells, extent: Vector, d_min: float
) -> tuple[Particles, Index, Cells]:
    """The particles that stay and are not too near to others, their indices, and their cells."""
    stay = np.flatnonzero(stays)
    particles = particles if stays.all() else particles.taken(stay)
    cells = build_cells(particles.position, extent, cells.size)
    kept = thinned(particles, cells, np.flatnonzero(awake[stay]), d_min)
    if kept.all():
        return particles, stay, cells
    left = cells.order[kept[cells.order]]  # in the order of their cells: what is near in space is then near in memory
    particles = particles.taken(left)
    return particles, stay[left], build_cells(particles.position, extent, cells.size)


def _joined(
    state: State, particles: Particles, births: Births, cells: Cells, arrived: Mask, d_min: float
) -> tuple[Particles, SurfaceCoverage, int]:
    """The particles with the new ones, those near new ground awake; the coverage; how many have found new ground."""
    contact, step = particles.on_surface, state.step_of_scale + 1
    assert state.space is not None
    covered = state.space.covered
    if covered.side != d_min:  # the ground of the present particles, in cells of another size
        covered, _ = cover_surfaces(
            no_surface(d_min), particles.position[contact.seated], contact.normal[contact.seated]
        )
    some = np.flatnonzero(arrived)
    places = np.concatenate([particles.position[some], births.position])
    covered, fresh = cover_surfaces(covered, places, np.concatenate([contact.normal[some], births.normal]))
    met = SurfaceContact.of_seated(births.normal, births.strength, step)
    met = met.woken_at(step - _OLD_GROUND, ~fresh[len(some) :])
    woken = np.zeros(len(particles), bool)
    _wake(cells, places[fresh], _WOKEN * ROOM * d_min, woken)
    particles = replace(particles, contact=contact.woken_at(step, woken))
    if len(births.position):
        particles = particles.with_more(births.position, state.next_identity, met)
    return particles, covered, int(np.count_nonzero(fresh))


@compiled
def _wake(cells: Cells, places: Array, reach: float, woken: Mask) -> None:
    """Mark the particles that are within reach of places."""
    found = room_for(cells)
    for q in range(len(places)):
        for n in range(near(cells, row_of(places, q), reach, found)):
            woken[cells.order[found[n]]] = True


_QUIET, _ENDED = 2, 4
"""Consecutive quiet steps after which particles are launched or a coarser scale ends, and those that end the run."""

_STEPS_A_UNIT, _LEAST_STEPS = 2.0, 400
"""Greatest number of steps of a scale for each unit of the longest side, and its least value."""


def stepped(state: State, field: VolumeField, regions: AnyRegions | None, parameters: Parameters) -> State:
    """The state after one time step, and after the end of its scale or its run if that has come."""
    state = moved_on(state, field, parameters)
    if not state.count:
        return state.stopped("all particles left the volume")
    most = max(_LEAST_STEPS, int(_STEPS_A_UNIT * max(field.extent)))
    overdue = state.step_of_scale - state.reactivated >= most
    if state.scale > 0:
        if state.quiet < _QUIET and not overdue:
            return state
        return start_scale(drop_unseated(state, field), state.scale - 1, regions)
    if state.quiet >= _QUIET:
        continued = reseed_surface(state, field, parameters.d_min)
        if continued is not None:
            return continued
    if state.quiet >= _ENDED:
        return drop_unseated(state, field).stopped("at rest: no particle finds anything new", True)
    return state.stopped(f"not at rest after {most} steps at full size") if overdue else state


def forces(state: State, field: VolumeField, _charged: VolumeField, parameters: Parameters, which: Index) -> Forces:
    """Forces on the particles `which`, shape (M,), of a state as the next step begins; see `Engine.forces`."""
    charges = Placed(state.placed, radius_at(state.scale))
    idle, awake = rested(state.particles, state.step_of_scale)
    coulomb, lorentz, placed, friction = parts_of_force(
        state.particles, which, cells_of(state.particles, field, parameters.d_min), idle, field, parameters, charges
    )
    beta = np.array([damping(parameters.beta, int(steps)) for steps in idle[which]])
    damped = -beta[:, None] * state.particles.velocity[which]
    asleep = ~awake[which]
    friction[asleep] = -(coulomb + lorentz + placed)[asleep]
    damped[asleep] = 0.0
    return Forces(coulomb, lorentz, placed, friction, damped)


_LEAST_SQUARE = 1e-4
"""Least squared distance of two particles in their energy [units^2], as in their force."""


def energies(state: State, field: VolumeField, parameters: Parameters) -> Energies:
    """Energies of a state with its placed charges; `field` is without them. See `Engine.energies`."""
    particles, contact = state.particles, state.particles.on_surface
    position, reach = particles.position, REACH * parameters.d_min
    cells = cells_of(particles, field, parameters.d_min)
    pairs = _pair_energy(cells, position, contact.normal, contact.seated, reach)
    fixed = interpolate(field.potential[None], position / field.pitch).sum() / field.slope
    placed = placed_potential(state.placed, radius_at(state.scale), position).sum()
    mutual = PAIR * parameters.w1 * parameters.d_min**3 * pairs
    in_volume = 4.0**state.scale
    return Energies(kinetic_energy(state), in_volume * (mutual + parameters.w2 * float(fixed + placed)))


@compiled
def _pair_energy(cells: Cells, position: Array, normals: Array, seated: Mask, reach: float) -> float:
    """Sum of ``(1/r^2 - 1/R^2) / 2`` over the pairs nearer than the reach R, except for those on different sheets."""
    total, found = 0.0, room_for(cells)
    for i in range(len(position)):
        place = row_of(position, i)
        for n in range(near(cells, place, reach, found)):
            k = found[n]
            away = difference(place, row_of(cells.place, k))
            if cells.order[k] < i and on_one_sheet(i, cells.order[k], normals, seated):
                total += 0.5 * (1.0 / max(dot(away, away), _LEAST_SQUARE) - 1.0 / (reach * reach))
    return total
