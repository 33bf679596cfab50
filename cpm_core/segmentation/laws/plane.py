"""The laws of a run in the plane."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from cpm_core.contours.contour import Bridge
from cpm_core.contours.result import Result
from cpm_core.dynamics.energies import Energies
from cpm_core.dynamics.energies.plane import energies
from cpm_core.dynamics.equations import FADED
from cpm_core.dynamics.forces import Forces
from cpm_core.dynamics.forces.plane import forces
from cpm_core.dynamics.integrator import Moved
from cpm_core.dynamics.time_step.plane import displaced, populated
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.image import Image
from cpm_core.image.pyramid import to_image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters import Parameters
from cpm_core.particles.coverage import no_coverage
from cpm_core.particles.state import Particles, State
from cpm_core.reconstruction import find_contours
from cpm_core.segmentation import interventions
from cpm_core.segmentation.completion.plane import idle_steps_of
from cpm_core.segmentation.laws.outcome import forces_asked, result_of
from cpm_core.segmentation.reach.reach_map import ReachMap
from cpm_core.segmentation.scale_schedule import advance

Populate = Callable[[State, Moved, bool, ScaleField, Parameters], State]
"""Insertion and deletion of a step."""


def first(points: Array, image: Image, scales: int, regions: AnyRegions | None) -> State:
    """A state without particles, from which the first scale begins."""
    none = Particles.at_rest(points[:0])
    return State(none, points, image.shape, scales, no_coverage(()), regions=regions)


def applied(state: State, regions: AnyRegions | None, parameters: Parameters, charges: Sequence[PlacedCharge]) -> State:
    """The state with which a step begins; see `interventions.applied`."""
    return interventions.applied(state, regions, parameters, charges)


def stepped(
    state: State,
    field: ScaleField,
    regions: AnyRegions | None,
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
    return forces_asked(state, changed, asked, lambda row: forces(changed, field, charged, idle, parameters, row))


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
    return result_of(state, image, parameters, contours=contours, surface=None, bridges=bridges)
