"""Changes of a run under way: by the user, and by the schedule of scales."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.field.placed_charges import (
    CHARGE_REACH,
    Charges,
    PlacedCharge,
    changed_charges,
    charge_radius_at,
    check_charges,
    near_charges,
)
from cpm_core.image.pyramid import shape_at_scale, to_image, to_scale
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.coverage import (
    COVERAGE_CELL,
    NEVER_COVERED,
    Coverage,
    no_coverage,
    no_surface_coverage,
    with_times_reset,
    with_times_reset_near,
)
from cpm_core.model.starts import check_seeds, is_allowed, is_inside_image
from cpm_core.model.state import Particles, State
from cpm_core.numerics.grids import Window, window_shape
from cpm_core.numerics.types import Array, Extent, Mask
from cpm_core.parameters import Parameters

ParticleSelection = Mask | Callable[[Array], ArrayLike]


def apply_interventions(
    state: State, regions: AnyRegions | None, parameters: Parameters, charges: Sequence[PlacedCharge]
) -> State:
    """Return the state with which a step begins, reactivated where parameters, regions or charges have changed."""
    if state.steering != parameters.steering or state.regions != regions:
        state = replace(reactivate_all(limit_to_regions(state, regions)), steering=parameters.steering)
    placed = check_charges(charges, len(state.shape))
    return state if state.charges == placed else change_charges(state, placed)


def reactivate_all(state: State) -> State:
    """Reactivate all particles, so that those at rest follow the change."""
    return replace(
        state,
        particles=state.particles.reactivate(state.step_of_scale),
        coverage=with_times_reset(state.coverage, state.step_of_scale),
        annealed=1.0,
        erased=False,
        reactivated=state.step_of_scale,
        idle=0,
        quiet=0,
        reseedings=0,
        mesh=None,
    )


def limit_to_regions(state: State, regions: AnyRegions | None) -> State:
    """Continue in other regions with the particles inside them."""
    if state.regions == regions:
        return state
    allowed = is_allowed(state.position, regions)
    return replace(state, particles=state.particles.keep(allowed), regions=regions)


def change_charges(state: State, charges: Charges) -> State:
    """Continue with other placed charges, in order, and reactivate the particles within reach of a changed one."""
    step, others = state.step_of_scale, replace(state, charges=changed_charges(state.charges, charges)).placed
    if state.space is not None:
        near = near_charges(others, charge_radius_at(state.scale), state.particles.position)
        woken = state.particles.reactivate(step, near)
        return replace(
            state, particles=woken, charges=charges, annealed=1.0, reactivated=step, idle=0, quiet=0, reseedings=0
        )
    coverage = with_times_reset_near(state.coverage, others[:, :2], CHARGE_REACH * 0.5**state.scale, step)
    valid = state.mesh is not None and len(state.mesh.force) > 0  # else all particles may have been at rest
    mesh = state.mesh if valid else None
    return replace(state, charges=charges, coverage=coverage, annealed=1.0, reactivated=step, quiet=0, mesh=mesh)


def add_particles(state: State, seeds: ArrayLike, regions: AnyRegions | None) -> State:
    """Add particles, shape (M, D), to a run; see `Engine.joined`."""
    points = check_seeds(seeds, state.shape, regions)
    places = state.at_scale(points, state.scale) - state.corner
    particles = state.particles.append(places, state.next_identity)
    joined = replace(
        state,
        particles=particles,
        start=np.concatenate([state.start, points]),
        next_identity=state.next_identity + len(points),
    )
    return widen_window(reactivate_all(joined).resume())


def erase_particles(state: State, inside: ParticleSelection) -> State:
    """Remove particles from a run; see `Engine.erased`."""
    if callable(inside):
        gone = _check_mask(inside(state.position), state.count, "particles")
        start = state.start[~_check_mask(inside(state.start), len(state.start), "starting particles")]
    else:
        gone, start = _check_mask(inside, state.count, "particles"), state.start
    if not gone.any() and len(start) == len(state.start):
        return state
    rest = replace(state, particles=state.particles.keep(~gone), start=start, mesh=None, erased=True)
    return rest if rest.count else rest.stop("all particles have been erased")


def _check_mask(inside: ArrayLike, count: int, noun: str) -> Mask:
    """Check a mask of the selected particles, shape (N,)."""
    mask = np.asarray(inside)
    if mask.dtype != np.bool_ or mask.shape != (count,):
        raise ValueError(f"which {noun} to erase must be given by {count} truth values, one for each.")
    return mask


def start_scale(state: State, scale: int, regions: AnyRegions | None) -> State:
    """Begin a scale with the particles of the coarser one and with all seeds."""
    coarser_and_seeds = (state.position, state.start)
    position = np.concatenate([allowed_places(places, scale, state.shape, regions) for places in coarser_and_seeds])
    shape, first, space = shape_at_scale(state.shape, scale), state.next_identity, state.space
    if space is not None:
        position, space = position * space.pitch, replace(space, covered=no_surface_coverage())
    windowed = len(shape) == 2 and math.prod(state.shape) > _MIN_WINDOWED_PIXELS
    state = replace(state, window=window_around(position, shape) if windowed else None)
    if state.window:
        position, shape = position - state.corner, window_shape(state.window)
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


def allowed_places(position: Array, scale: int, shape: Extent, regions: AnyRegions | None) -> Array:
    """Return positions, shape (N, D) [px of the image], at a scale, without those where no particle may be."""
    places = to_scale(position, scale, shape)
    places = places[is_inside_image(places, shape_at_scale(shape, scale))]
    return places[is_allowed(to_image(places, scale, shape), regions)]


_WINDOW_END_DISTANCE = 16.0
"""Distance of a particle from the end of a window that widens it [px]: farther than any moves or searches in a step."""

_MIN_WINDOW_ROOM = 96
"""Least room around particles in a new window [px]."""

_MIN_WINDOWED_PIXELS = 2**20
"""Pixels of an image above which a run takes place in windows."""

_MAX_WINDOW_SHARE = 0.5
"""Largest share of an image that a window may cover; beyond it the run takes place in the whole image."""


def window_around(position: Array, shape: Extent, room: float = 0.0) -> Window | None:
    """Return the pixels of a scale of this shape around particles, with some room [px] to move; None for all.

    Windows begin between cells of the coverage, so that a wider window has the same cells.
    """
    if not len(position):
        return None
    low, high = position.min(axis=0), position.max(axis=0)
    room = max(room, _MIN_WINDOW_ROOM, float(np.max(high - low)) / 2.0)
    first = (np.clip(low - room, 0, shape) // COVERAGE_CELL * COVERAGE_CELL).astype(int)
    end = np.clip(np.ceil((high + room) / COVERAGE_CELL) * COVERAGE_CELL, 0, shape).astype(int)
    if np.prod(end - first) > _MAX_WINDOW_SHARE * np.prod(shape):
        return None
    return tuple(map(slice, first.tolist(), end.tolist()))


def widen_window(state: State) -> State:
    """Widen the window of a state if particles have come near its end; else return the state."""
    if state.window is None or not state.count:
        return state
    shape, position = shape_at_scale(state.shape, state.scale), state.particles.position + state.corner
    first, last = np.transpose([(side.start, side.stop - 1) for side in state.window])
    near = (first > 0) & (position.min(axis=0) - first < _WINDOW_END_DISTANCE)
    if not (near | ((last + 1 < shape) & (last - position.max(axis=0) < _WINDOW_END_DISTANCE))).any():
        return state
    window = window_around(np.concatenate([position, [first, last]]), shape)
    moved, former = replace(state, window=window, mesh=None), state.coverage.found.shape
    before = (np.subtract(state.corner, moved.corner) / COVERAGE_CELL).astype(int)
    behind = np.subtract(no_coverage(window_shape(window) if window else shape).found.shape, former) - before
    around = np.transpose([before, behind])
    found, latest = (np.pad(steps, around, constant_values=NEVER_COVERED) for steps in state.coverage[:2])
    particles = replace(state.particles, position=position - moved.corner)
    return replace(moved, particles=particles, coverage=Coverage(found, latest, state.coverage.size))
