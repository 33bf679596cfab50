"""The two halves of a step: motion, and the population that deletion, insertion and annealing make of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cpm_core.dynamics.barrier_contact import held_back
from cpm_core.dynamics.deletion import thinned
from cpm_core.dynamics.edge_contact import EdgeContact
from cpm_core.dynamics.equilibrium import IDLE_STEPS, STILL, epsilon, is_idle
from cpm_core.dynamics.insertion import insertion, search_range
from cpm_core.dynamics.integrator import Moved, far_force_of, move
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.types import Index
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list import build_cells
from cpm_core.particles.coverage import cover, idle_at
from cpm_core.particles.starting_points import inside_image
from cpm_core.particles.state import State

_FRONT, _LOOK_EVERY, _LOOK_IDLY = 20, 4, 8
"""Steps without new ground around it up to which a particle with an open side looks for places at every step, for a
front must not wait; how often others look, and how often ahead where nothing new has been found for longer."""

_LATE_EVERY, _COLD_EVERY = 2, 4
"""How often particles are deleted and inserted once next to no new ground is found, and once no repulsion is left."""


def displaced(state: State, idle: Index, scale_field: ScaleField, parameters: Parameters) -> tuple[State, Moved]:
    """Force and motion, and removal of what leaves the image."""
    particles, step = state.particles, state.step_of_scale
    far = far_force_of(state, idle, scale_field, parameters)
    moved = move(particles, idle, far, scale_field, parameters)
    held = held_back(scale_field.barrier_map, particles, moved.particles)
    if held is not moved.particles:
        moved = moved.held_at(held, particles.position, scale_field)
    inside = inside_image(held.position, scale_field.shape)
    left = len(held) - int(np.count_nonzero(inside))
    if left:
        moved = moved.where(inside)
    motion = moved.motion
    state = replace(
        state,
        particles=moved.particles,
        far=far,
        step=state.step + 1,
        step_of_scale=step + 1,
        born=0,
        deleted=left,
        displacement=float(motion.mean()) if len(motion) else float("nan"),
        moving=int(np.count_nonzero(motion > STILL)),
        epsilon=epsilon(moved.particles.distance),
    )
    return state, moved


def populated(
    state: State, moved: Moved, repulsion_gone: bool, scale_field: ScaleField, parameters: Parameters
) -> State:
    """Deletion, insertion and annealing; late in a run the first two only now and then."""
    annealed = state.annealed * parameters.annealing
    every = _COLD_EVERY if repulsion_gone else _LATE_EVERY if state.idle >= IDLE_STEPS else 1
    if state.step % every:
        return replace(state, annealed=annealed, idle=state.idle + 1)
    particles, step, stirred = state.particles, state.step_of_scale, moved.motion > 0.0
    height, width = scale_field.shape
    cells = build_cells(particles.position, height, width, search_range(parameters))
    contact = EdgeContact(moved.strength, moved.on_edge, cells)
    kept = thinned(contact, stirred, parameters.d_min)
    coverage, new = cover(state.coverage, particles.position, contact.on_edge & kept, step)
    round_ = state.step // every
    turn = particles.identity + round_
    front = idle_at(coverage, particles.position, step, state.idle) < _FRONT
    thorough = (turn % _LOOK_EVERY == 0) | particles.young | repulsion_gone
    looking = (thorough | front) & stirred
    ahead = (turn % _LOOK_IDLY == 0) | front
    d_max = state.annealed * parameters.d_max
    births = insertion(contact, kept, looking, thorough, ahead, scale_field, d_max, parameters, round_)
    born, deleted = len(births.position), len(kept) - int(np.count_nonzero(kept))
    if born:
        particles = particles.joined_by(births.position, births.parent, births.other, state.next_identity)
    if deleted:  # those who stay, in the order of their cells: what is near in space is then near in memory
        stay = contact.cells.order[kept[contact.cells.order]]
        particles = particles.taken(np.concatenate([stay, np.arange(len(kept), len(kept) + born)]))
    return replace(
        state,
        particles=particles,
        annealed=annealed,
        next_identity=state.next_identity + born,
        born=born,
        deleted=state.deleted + deleted,
        coverage=coverage,
        idle=state.idle + 1 if is_idle(new, coverage.size) else 0,
    )
