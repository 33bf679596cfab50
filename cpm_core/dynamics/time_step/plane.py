"""The two halves of a step: motion, then deletion, insertion and annealing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cpm_core.dynamics.barrier_contact.plane import held_back
from cpm_core.dynamics.deletion.plane import thinned
from cpm_core.dynamics.edge_contact import EdgeContact
from cpm_core.dynamics.edge_contact.plane import contact_at
from cpm_core.dynamics.equilibrium import IDLE_STEPS, STILL, epsilon, is_idle
from cpm_core.dynamics.insertion import Search, search_range
from cpm_core.dynamics.insertion.plane import insertion
from cpm_core.dynamics.integrator import Moved
from cpm_core.dynamics.integrator.plane import mesh_force_of, move
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.types import Index
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list.plane import build_cells
from cpm_core.particles.coverage import cover, idle_at
from cpm_core.particles.initialization import inside_image
from cpm_core.particles.state import State

_FRONT, _SEARCH_EVERY, _AHEAD_EVERY = 20, 4, 8
"""Steps since newly covered cells up to which a particle belongs to a front and searches at every step; how often
others search, and how often they search ahead."""

_LATE_EVERY, _FADED_EVERY = 2, 4
"""How often particles are deleted and inserted once coverage hardly grows, and once no repulsion is left."""


def displaced(state: State, idle: Index, scale_field: ScaleField, parameters: Parameters) -> tuple[State, Moved]:
    """Forces and motion, and removal of particles that leave the image."""
    particles, step = state.particles, state.step_of_scale
    mesh = mesh_force_of(state, idle, scale_field, parameters)
    moved = move(particles, idle, mesh, scale_field, parameters)
    held = held_back(scale_field.barrier_map, particles, moved.particles)
    if held is not moved.particles:
        moved = Moved.held_at(held, particles.position, contact_at(held.position, scale_field))
    inside = inside_image(held.position, scale_field.shape)
    left = len(held) - int(np.count_nonzero(inside))
    if left:
        moved = moved.where(inside)
    motion = moved.motion
    state = replace(
        state,
        particles=moved.particles,
        mesh=mesh,
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
    """Deletion, insertion and annealing; late in a run the first two happen only at some steps."""
    annealed = state.annealed * parameters.annealing
    every = _FADED_EVERY if repulsion_gone else _LATE_EVERY if state.idle >= IDLE_STEPS else 1
    if state.step % every:
        return replace(state, annealed=annealed, idle=state.idle + 1)
    particles, step, has_moved = state.particles, state.step_of_scale, moved.motion > 0.0
    cells = build_cells(particles.position, scale_field.shape, search_range(parameters))
    contact = EdgeContact(moved.strength, moved.on_edge, cells)
    kept = thinned(contact, has_moved, parameters.d_min)
    coverage, new = cover(state.coverage, particles.position, contact.on_edge & kept, step)
    round_ = state.step // every
    turn = particles.identity + round_
    front = idle_at(coverage, particles.position, step, state.idle) < _FRONT
    thorough = (turn % _SEARCH_EVERY == 0) | particles.young | repulsion_gone
    looking = (thorough | front) & has_moved
    ahead = (turn % _AHEAD_EVERY == 0) | front
    d_max = state.annealed * parameters.d_max
    search = Search(kept, looking, thorough, ahead)
    births = insertion(contact, search, scale_field, d_max, parameters, round_)
    born, deleted = len(births.position), len(kept) - int(np.count_nonzero(kept))
    if born:
        particles = particles.joined_by(births.position, births.parent, births.other, state.next_identity)
    if deleted:  # in the order of their cells: what is near in space is then near in memory
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
