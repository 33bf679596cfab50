"""The two halves of a step: motion, and the population that deletion, insertion and annealing make of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cpm_core.dynamics.deletion import thinned
from cpm_core.dynamics.edge_contact import Standing
from cpm_core.dynamics.equilibrium import IDLE_STEPS, STILL, epsilon, is_idle
from cpm_core.dynamics.insertion import insertion, search_range
from cpm_core.dynamics.integrator import Moved, far_force_of, move
from cpm_core.field.scale_field import Level
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list import build_cells
from cpm_core.particles.coverage import explore, idle_at
from cpm_core.particles.starting_points import inside_image
from cpm_core.particles.state import State

Index = NDArray[np.int64]

_FRONT, _LOOK_EVERY, _LOOK_IDLY = 20, 4, 8
"""Steps without new ground around it up to which a particle with an open side looks for places at every step, for a
front must not wait; how often others look, and how often ahead where nothing new has been found for longer."""

_LATE_EVERY, _COLD_EVERY = 2, 4
"""How often particles are deleted and inserted once next to no new ground is found, and once no repulsion is left."""


def displaced(state: State, idle: Index, level: Level, parameters: Parameters) -> tuple[State, Moved]:
    """Force and motion, and removal of what leaves the image."""
    particles, step = state.particles, state.step_of_scale
    far = far_force_of(state, idle, level, parameters)
    moved = move(particles, idle, far, level, parameters)
    held = level.walls.held(particles, moved.particles)
    if held is not moved.particles:
        moved = moved.held_at(held, particles.position, level)
    inside = inside_image(held.position, level.shape)
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


def populated(state: State, moved: Moved, cold: bool, level: Level, parameters: Parameters) -> State:
    """Deletion, insertion and annealing; late in a run the first two only now and then."""
    annealed = state.annealed * parameters.annealing
    every = _COLD_EVERY if cold else _LATE_EVERY if state.idle >= IDLE_STEPS else 1
    if state.step % every:
        return replace(state, annealed=annealed, idle=state.idle + 1)
    particles, step, stirred = state.particles, state.step_of_scale, moved.motion > 0.0
    height, width = level.shape
    cells = build_cells(particles.position, height, width, search_range(parameters))
    standing = Standing(moved.strength, moved.seated, cells)
    kept = thinned(standing, stirred, parameters.d_min)
    ground, new = explore(state.ground, particles.position, standing.seated & kept, step)
    round_ = state.step // every
    turn = particles.identity + round_
    front = idle_at(ground, particles.position, step, state.idle) < _FRONT
    thorough = (turn % _LOOK_EVERY == 0) | particles.young | cold
    looking = (thorough | front) & stirred
    ahead = (turn % _LOOK_IDLY == 0) | front
    d_max = state.annealed * parameters.d_max
    births = insertion(standing, kept, looking, thorough, ahead, level, d_max, parameters, round_)
    born, deleted = len(births.position), len(kept) - int(np.count_nonzero(kept))
    if born:
        particles = particles.joined_by(births.position, births.parent, births.other, state.next_identity)
    if deleted:  # those who stay, in the order of their cells: what is near in space is then near in memory
        stay = standing.cells.order[kept[standing.cells.order]]
        particles = particles.taken(np.concatenate([stay, np.arange(len(kept), len(kept) + born)]))
    return replace(
        state,
        particles=particles,
        annealed=annealed,
        next_identity=state.next_identity + born,
        born=born,
        deleted=state.deleted + deleted,
        ground=ground,
        idle=state.idle + 1 if is_idle(new, ground.size) else 0,
    )
