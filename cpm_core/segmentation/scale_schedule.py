"""The scale schedule of a run: from coarse to fine, and to its end."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cpm_core.dynamics.equilibrium import IDLE_STEPS, QUIET_STEPS, is_quiet
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.pyramid import shape_of_scale, to_image, to_scale
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.parameters import Parameters
from cpm_core.particles.coverage import no_coverage
from cpm_core.particles.initialization import allowed_by, inside_image
from cpm_core.particles.state import Particles, State
from cpm_core.particles.surface_coverage import no_surface
from cpm_core.segmentation.completion.plane import is_travelling, reseeded, without_off_edge, without_resting_off_edge

_STEPS_A_PIXEL = 2.0
"""Greatest number of steps of a scale for each pixel of the longest side: a front advances about two pixels a step."""

_LEAST_STEPS = 400
"""Number of steps that every scale may take."""


def advance(state: State, scale_field: ScaleField, regions: AnyRegions | None, parameters: Parameters) -> State:
    """End a scale or the run at equilibrium or after the greatest number of steps; else return the state."""
    quiet = is_quiet(state.epsilon, state.moving, state.born + state.deleted, state.count)
    state = replace(state, quiet=state.quiet + 1 if quiet else 0)
    most = max(_LEAST_STEPS, int(_STEPS_A_PIXEL * max(scale_field.shape)))
    overdue = state.step_of_scale - state.reactivated >= most
    if state.scale > 0:
        done = state.idle >= IDLE_STEPS and not is_travelling(state, parameters)
        if state.count == 0 or done or overdue:
            return start_scale(without_off_edge(state, scale_field, and_drawn=True), state.scale - 1, regions)
        return state
    if state.count == 0:
        return state.stopped("all particles left the image")
    if state.quiet >= QUIET_STEPS:
        continued = reseeded(state, scale_field)
        if continued is not None:
            return continued
        reason = f"at rest: nothing has moved, appeared or vanished for {QUIET_STEPS} steps"
        return without_resting_off_edge(state, scale_field).stopped(reason, True)
    if overdue:
        return state.stopped(f"not at rest after {most} steps at full size")
    return state


def start_scale(state: State, scale: int, regions: AnyRegions | None) -> State:
    """Begin a scale with the particles of the coarser one and with all seeds."""
    position = np.concatenate([to_scale(places, scale, state.shape) for places in (state.position, state.start)])
    shape = shape_of_scale(state.shape, scale)
    position = position[inside_image(position, shape)]
    position = position[allowed_by(to_image(position, scale, state.shape), regions)]
    first, space = state.next_identity, state.space
    if space is not None:
        position, space = position * space.pitch, replace(space, covered=no_surface())
    return replace(
        state,
        particles=Particles.at_rest(position, first),
        scale=scale,
        step_of_scale=0,
        next_identity=first + len(position),
        coverage=no_coverage(shape),
        annealed=1.0,
        reactivated=0,
        idle=0,
        quiet=0,
        reseedings=0,
        mesh=None,
        epsilon=float("nan"),
        space=space,
    )
