"""A step in a volume: motion, deletion and insertion of the particles that are awake.

A particle sleeps once no new ground has been found near it for some steps: a cell and side where no surface had been
found before. What is inserted on old ground wakes nobody; else a crowd on one surface would stir itself up for ever. A
particle that has found no surface goes when it has been slow for long: it hovers between others.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cpm_core.dynamics.barrier_contact.space import held_back
from cpm_core.dynamics.deletion.space import thinned
from cpm_core.dynamics.equilibrium import STILL, epsilon
from cpm_core.dynamics.insertion.space import ROOM, Births, insertion
from cpm_core.dynamics.integrator.space import REACH, move
from cpm_core.field.placed_charges import radius_at
from cpm_core.field.volume.placed_charges import Placed
from cpm_core.field.volume.volume_field import VolumeField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.numerics.vectors import Vector
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list.space import Cells, build_cells, cells_around, row_of_cells
from cpm_core.particles.state import Particles, SpaceState, State
from cpm_core.particles.surface_contact import SurfaceContact
from cpm_core.particles.surface_coverage import SurfaceCoverage, cover, no_surface

_AWAKE, _PATIENCE = 12, 60
"""Steps without new ground after which a seated particle sleeps, and slow ones after which a free particle goes."""

_OLD_GROUND = 6
"""Steps that a particle inserted on old ground has been awake already."""

_WOKEN = 3.0
"""Distance from new ground up to which others wake, in the least distances of new particles."""

_UNDER_WAY, _LEAST_BETA = 0.3, 0.1
"""Fraction of the speed that the field alone gives a particle above which it is under way, and the least damping with
which that speed is estimated."""

_LEAST_CELL = 4.0
"""Least side of a cell, which limits the memory however small the distances [units]."""

_FEW_NEW, _FEW_AWAKE, _LONG = 0.0005, 0.02, 15
"""Fractions of the particles that may find new ground in a quiet step, and be awake in it, unless nothing new has been
found for so many steps."""


def stepped(state: State, field: VolumeField, parameters: Parameters) -> State:
    """The state after one time step, before it is decided whether the run goes on."""
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
    stays = _inside(after.position, extent, space) & (_contact(before).seated | (idle < _PATIENCE))
    if field.walls is not None:
        after = held_back(field.walls, before, after)
    flying = ~_contact(after).seated & _is_fast(after, parameters) & (step < 2.0 * max(extent) + state.reactivated)
    arrived = _contact(after).seated & ~_contact(before).seated
    after = replace(after, contact=_contact(after).woken_at(step + 1, flying))
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
    return build_cells(particles.position, field.extent, max(REACH * d_min, _LEAST_CELL))


def _contact(particles: Particles) -> SurfaceContact:
    assert particles.contact is not None
    return particles.contact


def rested(particles: Particles, step: int) -> tuple[Index, Mask]:
    """Steps since new ground was found near each particle, and which are awake."""
    contact = _contact(particles)
    idle = np.maximum(step - contact.woken, 0)
    return idle, (idle < _AWAKE) | (~contact.seated & (idle < _PATIENCE))


def _inside(position: Array, extent: Vector, space: SpaceState) -> Mask:
    """Which particles lie in the volume, between the centers of the outermost voxels."""
    last = np.array(extent) - np.array(space.pitch)
    return np.asarray(((position >= 0.0) & (position <= last)).all(axis=1))


def _is_fast(particles: Particles, parameters: Parameters) -> Mask:
    """Which particles move so fast that the field alone must drive them."""
    driven = parameters.w2 / max(parameters.beta, _LEAST_BETA)
    return np.asarray(np.einsum("ni,ni->n", particles.velocity, particles.velocity) > (_UNDER_WAY * driven) ** 2)


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
    contact, step = _contact(particles), state.step_of_scale + 1
    assert state.space is not None
    covered = state.space.covered
    if covered.side != d_min:  # the ground of the present particles, in cells of another size
        covered, _ = cover(no_surface(d_min), particles.position[contact.seated], contact.normal[contact.seated])
    some = np.flatnonzero(arrived)
    places = np.concatenate([particles.position[some], births.position])
    covered, fresh = cover(covered, places, np.concatenate([contact.normal[some], births.normal]))
    met = SurfaceContact.of_seated(births.normal, births.strength, step)
    met = met.woken_at(step - _OLD_GROUND, ~fresh[len(some) :])
    woken = np.zeros(len(particles), np.bool_)
    _wake(cells, places[fresh], _WOKEN * ROOM * d_min, woken)
    particles = replace(particles, contact=contact.woken_at(step, woken))
    if len(births.position):
        particles = particles.with_more(births.position, state.next_identity, met)
    return particles, covered, int(np.count_nonzero(fresh))


@compiled
def _wake(cells: Cells, places: Array, reach: float, woken: Mask) -> None:
    """Mark the particles that are within reach of places."""
    for q in range(len(places)):
        z, y, x = places[q, 0], places[q, 1], places[q, 2]
        top, bottom, front, back, left, right = cells_around(cells, z, y, x, reach)
        for plane in range(top, bottom + 1):
            for row in range(front, back + 1):
                start, end = row_of_cells(cells, plane, row, left, right)
                for k in range(start, end):
                    away = (cells.z[k] - z) ** 2 + (cells.y[k] - y) ** 2 + (cells.x[k] - x) ** 2
                    if away < reach * reach:
                        woken[cells.order[k]] = True
