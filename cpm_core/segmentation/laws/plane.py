"""The laws of a run in the plane."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Bridge
from cpm_core.contours.result import Result
from cpm_core.dynamics.energies import Energies, energies
from cpm_core.dynamics.equations import FADED
from cpm_core.dynamics.forces import Forces, forces
from cpm_core.dynamics.integrator import Moved
from cpm_core.dynamics.time_step.plane import displaced, populated
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.image import Image
from cpm_core.image.pyramid import to_image
from cpm_core.image.regions import Regions
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters import Parameters
from cpm_core.particles.coverage import no_coverage
from cpm_core.particles.state import Particles, State
from cpm_core.reconstruction import find_contours
from cpm_core.segmentation import interventions
from cpm_core.segmentation.completion.plane import idle_steps_of
from cpm_core.segmentation.reach.reach_map import ReachMap
from cpm_core.segmentation.scale_schedule import advance

Populate = Callable[[State, Moved, bool, ScaleField, Parameters], State]
"""Insertion and deletion of a step."""


def first(points: Array, image: Image, scales: int, regions: Regions | None) -> State:
    """A state without particles, from which the first scale begins."""
    none = Particles.at_rest(points[:0])
    return State(none, points, image.shape, scales, no_coverage(()), regions=regions)


def applied(state: State, regions: Regions | None, parameters: Parameters, charges: Sequence[PlacedCharge]) -> State:
    """The state with which a step begins; see `interventions.applied`."""
    return interventions.applied(state, regions, parameters, charges)


def stepped(
    state: State,
    field: ScaleField,
    regions: Regions | None,
    parameters: Parameters,
    populate: Populate = populated,
) -> State:
    """The state after one time step, and after the end of its scale or its run if that has come.

    `field` includes the placed charges; `populate` can be replaced in experiments.
    """
    idle = idle_steps_of(state, field, parameters)
    repulsion_gone = not (idle < FADED).any()
    state, moved = displaced(state, idle, field, parameters)
    if len(state.particles):
        state = populate(state, moved, repulsion_gone, field, parameters)
    return advance(state, field, regions, parameters)


def forces_on(
    state: State, changed: State, field: ScaleField, charged: ScaleField, parameters: Parameters, asked: Index
) -> Forces:
    """Forces on some particles of a state, of which `changed` is the one with which the step begins.

    `field` and `charged` are the fields of its scale without and with the placed charges.
    """
    idle = idle_steps_of(changed, charged, parameters)
    row = _places(state.particles.identity, changed.particles.identity)[asked]
    there = row >= 0
    found = forces(changed, field, charged, idle, parameters, row[there])
    return found if there.all() else Forces(*(_spread(getattr(found, f.name), there) for f in fields(Forces)))


def energies_of(state: State, field: ScaleField, parameters: Parameters) -> Energies:
    """Energies of a state with its placed charges; `field` is without them."""
    return energies(state, field, parameters)


def result(
    state: State,
    image: Image,
    field: ScaleField,
    parameters: Parameters,
    reach_map: Callable[[Array, Parameters], ReachMap | None],
) -> Result:
    """Contours through the particles of a state, from the fields of its scale, in px of the image."""
    scale, shape, size = state.scale, image.shape, 2.0**state.scale
    # an edge without particles may have been cleared by the user; it is then not traced
    filled = state.converged and not state.charges and not state.erased
    found, bridged = find_contours(state.particles.position, field, parameters, at_rest=filled)
    contours = tuple(replace(c, points=to_image(c.points, scale, shape), strength=c.strength / size) for c in found)
    reached = reach_map(state.start, parameters)
    if reached is not None:
        contours = tuple(replace(c, reached=reached.way_of(c.points)) for c in contours)
    bridges = tuple(Bridge(to_image(b.points, scale, shape), b.length * size, b.strength / size) for b in bridged)
    return Result(
        particles=state.position,
        contours=contours,
        surface=None,
        steps=state.step,
        converged=state.converged,
        stop_reason=state.stop_reason,
        shape=shape,
        spacing=image.spacing,
        unit=image.unit,
        source=image.source,
        bridges=bridges,
        image=image,
        regions=state.regions,
        channel=image.channel(parameters.channel),
    )


def _places(before: Index, after: Index) -> Index:
    """For each earlier identity its index among the later ones, which keep their order; -1 where it is gone."""
    stays = np.isin(before, after)
    return np.where(stays, np.cumsum(stays) - 1, -1)


def _spread(rows: Array, there: NDArray[np.bool_]) -> Array:
    """Rows, shape (K, 2), at the positions where `there`, shape (M,), is true; NaN elsewhere."""
    spread = np.full((len(there), 2), np.nan)
    spread[there] = rows
    return spread
