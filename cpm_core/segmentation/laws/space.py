"""The laws of a run in a volume."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from cpm_core.contours.result import Result
from cpm_core.dynamics.energies import Energies
from cpm_core.dynamics.forces import Forces
from cpm_core.dynamics.time_step.space import stepped as moved
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.field.volume.volume_field import VolumeField
from cpm_core.field.volume.volume_space import pitch_of
from cpm_core.image.image import Image
from cpm_core.image.pyramid import to_image
from cpm_core.image.regions import Regions
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.particles.coverage import no_coverage
from cpm_core.particles.coverage.space import no_surface
from cpm_core.particles.state import Particles, SpaceState, State
from cpm_core.segmentation import interventions
from cpm_core.segmentation.completion.space import launched, settled
from cpm_core.segmentation.scale_schedule import start_scale

_QUIET, _ENDED = 2, 4
"""Consecutive quiet steps after which particles are launched or a coarser scale ends, and those that end the run."""

_STEPS_A_UNIT, _LEAST_STEPS = 2.0, 400
"""Greatest number of steps of a scale for each unit of the longest side, and its least value."""


def first(points: Array, image: Image, scales: int, regions: Regions | None) -> State:
    """A state without particles, from which the first scale begins."""
    none = Particles.at_rest(points[:0])
    space = SpaceState(pitch_of(image), no_surface())
    return State(none, points, image.shape, scales, no_coverage(()), regions=regions, space=space)


def applied(state: State, regions: Regions | None, parameters: Parameters, charges: Sequence[PlacedCharge]) -> State:
    """The state with which a step begins; see `interventions.applied`."""
    if charges:
        raise ValueError("charges cannot be placed in a volume: leave them out.")
    return interventions.applied(state, regions, parameters, ())


def stepped(state: State, field: VolumeField, regions: Regions | None, parameters: Parameters) -> State:
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


def forces_on(*_given: object) -> Forces:
    """Forces on single particles, which are not told apart in a volume."""
    raise ValueError("the forces on single particles are known in images only.")


def energies_of(*_given: object) -> Energies:
    """Energies, which are not defined in a volume: the force on a surface has no potential."""
    raise ValueError("energies are known in images only.")


def result(
    state: State, image: Image, field: VolumeField, parameters: Parameters, _reach: Callable[..., object]
) -> Result:
    """Particles of a state and the surface through those that are seated, in voxels."""
    from cpm_core.reconstruction.surface.iso.pipeline import find_surface  # noqa: PLC0415 - loads scipy.spatial

    particles, scale = state.particles, state.scale
    assert state.space is not None
    assert particles.contact is not None
    points = particles.position[particles.contact.seated] / state.space.pitch
    spacing = tuple(side * 2.0**scale for side in image.spacing)
    surface = find_surface(field.smoothed, field.edge_map, points, spacing, image.unit, smoothing=field.smoothing)
    if scale:
        surface = replace(surface, vertices=to_image(surface.vertices, scale, image.shape), spacing=image.spacing)
    return Result(
        particles=state.position,
        contours=(),
        surface=surface,
        steps=state.step,
        converged=state.converged,
        stop_reason=state.stop_reason,
        shape=image.shape,
        spacing=image.spacing,
        unit=image.unit,
        source=image.source,
        image=image,
        regions=state.regions,
        channel=image.channel(parameters.channel),
    )
