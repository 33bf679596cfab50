"""The laws of a run in a volume."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from cpm_core.contours.result import Result
from cpm_core.dynamics.energies import Energies
from cpm_core.dynamics.energies.space import energies
from cpm_core.dynamics.forces import Forces
from cpm_core.dynamics.forces.space import forces
from cpm_core.dynamics.time_step.space import stepped as moved
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.field.volume.volume_field import VolumeField
from cpm_core.field.volume.volume_space import pitch_of
from cpm_core.image.image import Image
from cpm_core.image.pyramid import to_image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters import Parameters
from cpm_core.particles.coverage import no_coverage
from cpm_core.particles.state import Particles, SpaceState, State
from cpm_core.particles.surface_coverage import no_surface
from cpm_core.segmentation import interventions
from cpm_core.segmentation.completion.space import launched, settled
from cpm_core.segmentation.laws.outcome import forces_asked, result_of
from cpm_core.segmentation.scale_schedule import start_scale

_QUIET, _ENDED = 2, 4
"""Consecutive quiet steps after which particles are launched or a coarser scale ends, and those that end the run."""

_STEPS_A_UNIT, _LEAST_STEPS = 2.0, 400
"""Greatest number of steps of a scale for each unit of the longest side, and its least value."""


def first(points: Array, image: Image, scales: int, regions: AnyRegions | None) -> State:
    """A state without particles, from which the first scale begins."""
    none = Particles.at_rest(points[:0])
    space = SpaceState(pitch_of(image.spacing), no_surface())
    return State(none, points, image.shape, scales, no_coverage(()), regions=regions, space=space)


def applied(state: State, regions: AnyRegions | None, parameters: Parameters, charges: Sequence[PlacedCharge]) -> State:
    """The state with which a step begins; see `interventions.applied`."""
    return interventions.applied(state, regions, parameters, charges)


def stepped(state: State, field: VolumeField, regions: AnyRegions | None, parameters: Parameters) -> State:
    """The state after one time step, and after the end of its scale or its run if that has come."""
    state = moved(state, field, parameters)
    if not state.count:
        return state.stopped("all particles left the volume")
    most = max(_LEAST_STEPS, int(_STEPS_A_UNIT * max(field.extent)))
    overdue = state.step_of_scale - state.reactivated >= most
    if state.scale > 0:
        if state.quiet < _QUIET and not overdue:
            return state
        return start_scale(settled(state, field), state.scale - 1, regions)
    if state.quiet >= _QUIET:
        continued = launched(state, field, parameters.d_min)
        if continued is not None:
            return continued
    if state.quiet >= _ENDED:
        return settled(state, field).stopped("at rest: no particle finds anything new", True)
    return state.stopped(f"not at rest after {most} steps at full size") if overdue else state


def forces_on(
    state: State, changed: State, field: VolumeField, _charged: VolumeField, parameters: Parameters, asked: Index
) -> Forces:
    """Forces on some particles of a state, of which `changed` is the one with which the step begins."""
    return forces_asked(state, changed, asked, lambda row: forces(changed, field, parameters, row))


def energies_of(state: State, field: VolumeField, parameters: Parameters) -> Energies:
    """Energies of a state with its placed charges."""
    return energies(state, field, parameters)


def result(
    state: State, image: Image, field: VolumeField, parameters: Parameters, _reach: Callable[..., object]
) -> Result:
    """Particles of a state and the surface through those that are seated, in voxels; it ends at walls."""
    from cpm_core.reconstruction.surface.iso.pipeline import find_surface  # noqa: PLC0415 - loads scipy.spatial

    particles, scale = state.particles, state.scale
    assert state.space is not None
    assert particles.contact is not None
    points = particles.position[particles.contact.seated] / state.space.pitch
    shut = None
    if field.walls is not None:
        shut = field.walls.shut(field.shape, field.pitch, particles.position[particles.contact.seated])
    spacing = tuple(side * 2.0**scale for side in image.spacing)
    fields = field.smoothed, field.edge_map
    surface = find_surface(*fields, points, spacing, image.unit, smoothing=field.smoothing, shut=shut)
    if scale:
        surface = replace(surface, vertices=to_image(surface.vertices, scale, image.shape), spacing=image.spacing)
    return result_of(state, image, parameters, contours=(), surface=surface)
