"""Center lines in a volume of gray levels: those of what lies inside the surface through its edges, without seeds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.contours.surface.inside import inside_of
from cpm_core.field.volume_field import VolumeField, check_parameters
from cpm_core.image.image import Image
from cpm_core.medial_axis.space.centerlines import Centerlines, centerlines
from cpm_core.model.image_fields import ImageFields
from cpm_core.numerics.real_numbers import real_numbers
from cpm_core.numerics.types import Array, Mask
from cpm_core.parameters import Parameters
from cpm_core.parameters.provenance import Provenance, taken
from cpm_core.parameters.quotation import shown
from cpm_core.reconstruction.surface.iso.pipeline import find_surface

OF_CENTERLINES = ("smoothing", "gamma", "edge_floor", "polarity", "pruning")
"""Parameters that the center lines of gray levels depend on."""


def volume_skeleton(
    image: Image,
    parameters: Parameters,
    within: Sequence[Contour] | ArrayLike | None = None,
    *,
    outside: bool = False,
) -> Centerlines:
    """Center lines of what is lighter than its surroundings in a volume, or darker; `within` is a mask in its place.

    A volume of two gray levels is a mask itself. `Parameters.pruning` is in radii, as for `centerlines`.
    """
    check_parameters(parameters)
    for name, value in (("outside", outside), ("max_width", parameters.max_width)):
        if value:
            raise ValueError(f"{name} is {shown(value)} but has no meaning in a volume: leave it out.")
    inside = inside_edges(image, parameters, parameters.polarity < 0.0) if within is None else _mask(within, image)
    found = centerlines(inside, image.spacing, image.unit, parameters.pruning)
    made = Provenance(
        "skeleton",
        taken(parameters, ("pruning",) if within is not None else OF_CENTERLINES),
        sha256=image.sha256,
        of_file=bool(image.file_sha256),
    )
    return replace(found, source=image.source, geometry=image.geometry, provenance=made)


def _mask(given: Sequence[Contour] | ArrayLike, image: Image) -> Mask:
    """A given mask; ValueError when its shape is not that of the volume."""
    if isinstance(given, Sequence) and any(isinstance(one, Contour) for one in given):
        raise ValueError("within holds contours, which lie in a plane: give a mask in a volume.")
    mask = real_numbers(cast("ArrayLike", given)) != 0.0
    if mask.shape != image.shape:
        raise ValueError(
            f"within has the shape {mask.shape}, but {image.source} has {image.shape}: give a mask of that shape."
        )
    return np.asarray(mask)


def inside_edges(image: Image, parameters: Parameters, dark: bool) -> Mask:
    """The voxels of a volume that are lighter than its edges, or darker."""
    low, high = image.gray_range
    if low < high and _is_mask(image.values, low, high):
        return np.asarray(image.values == (low if dark else high))
    field = cast("VolumeField", ImageFields(image, replace(parameters, scales=1)).scale_field(parameters))
    smoothed = -field.smoothed if dark else field.smoothed  # inside is what is lighter
    places = field.ridges.place / field.pitch
    surface = find_surface(smoothed, field.edge_map, places, image.spacing, image.unit, smoothing=field.smoothing)
    return inside_of(surface, image.shape)


def _is_mask(values: Array, low: float, high: float) -> bool:
    """Whether a volume has two gray levels."""
    return bool(((values == low) | (values == high)).all())
