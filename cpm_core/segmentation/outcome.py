"""Result of a state of a run: contours through its particles, or a surface."""

from __future__ import annotations

from dataclasses import replace

from cpm_core.contours.contour import Bridge
from cpm_core.field.scale_field import ScaleField
from cpm_core.field.volume_field import VolumeField
from cpm_core.image.image import Image
from cpm_core.image.pyramid import to_image
from cpm_core.model.plane.state import PlaneState
from cpm_core.model.volume.state import VolumeState
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.reconstruction import find_contours
from cpm_core.results.result import Result, build_result


def find_state_contours(
    state: PlaneState,
    image: Image,
    field: ScaleField,
    parameters: Parameters,
) -> Result:
    """Find the contours, each of shape (K, 2) [px of the image], through the particles of a state."""
    size = 2.0**state.scale

    def to_image_places(points: Array) -> Array:
        return to_image(points + state.corner, state.scale, image.shape)

    # otherwise an edge may be without particles because the user cleared it, and must not be traced
    covers_edges = state.converged and not state.charges and not state.erased
    found, bridged, links = find_contours(state.particles.position, field, parameters, at_rest=covers_edges)

    places = [to_image_places(c.points) for c in found]
    contours = tuple(
        replace(c, points=points, strength=c.strength / size) for c, points in zip(found, places, strict=True)
    )
    bridges = tuple(Bridge(to_image_places(b.points), b.length * size, b.strength / size) for b in bridged)
    return build_result(
        state,
        image,
        parameters,
        contours=contours,
        surface=None,
        bridges=bridges,
        links=tuple(map(to_image_places, links)),
    )


def find_state_surface(state: VolumeState, image: Image, field: VolumeField, parameters: Parameters) -> Result:
    """Find the surface through the particles on surfaces of a state, in voxels; it ends at walls."""
    from cpm_core.reconstruction.surface.pipeline import find_surface  # noqa: PLC0415 - loads scipy.spatial

    particles, scale = state.particles, state.scale
    points = particles.position[particles.on_surface]
    shut = None if field.walls is None else field.walls.find_shut_voxels(field.shape, field.pitch, points)
    spacing = tuple(side * 2.0**scale for side in image.spacing)
    fields = field.smoothed, field.edge_map
    surface = find_surface(*fields, points / state.pitch, spacing, image.unit, smoothing=field.smoothing, shut=shut)
    if scale:
        surface = replace(surface, vertices=to_image(surface.vertices, scale, image.shape), spacing=image.spacing)
    return build_result(state, image, parameters, contours=(), surface=surface)
