"""The fields of one image: edge map, Lorentz force and potential at every scale, built on first use."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from threading import RLock
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.field.placed_charges import (
    Charges,
    PlacedCharge,
    add_charges,
    charge_radius_at,
    charges_at_scale,
    check_charges,
    placed_forces,
    placed_potential,
    windows_near_charges,
)
from cpm_core.field.scale_field import LARGE_IMAGE_PIXELS, ScaleField
from cpm_core.field.scale_space import SourceImages, plane_field_builders
from cpm_core.field.volume_field import check_volume_parameters, pitch_of, volume_field_builders
from cpm_core.image.image import Image, as_image
from cpm_core.image.volume_regions import AnyRegions, check_regions
from cpm_core.numerics.memory import check_field_memory
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, copy_with
from cpm_core.parameters import Parameters, choose_parameters

_MIN_BYTES_PER_PIXEL = {2: 80.0, 3: 16.0}
"""Least memory that a run needs for one pixel [bytes], by axes; in the plane 106 to 200 are measured."""


_KEPT_CHARGED_FIELDS = 2
"""Number of fields with placed charges that are kept: those that the threads of a run and a window use."""

FieldMeasure = Callable[[ScaleField, int, Parameters], ScaleField]
"""Completes the field of a part of an image by the quantities that depend on the whole image."""


class ImageFields:
    """An image and the fields that act on particles in it.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image
        Image or volume.
    parameters : Parameters or str, optional
        For the number of scales, and the fields to prepare at once.
    regions : Regions or VolumeRegions, optional
        Regions of interest, which particles do not leave, and barriers, which they do not cross; the whole image by
        default.
    measured : callable, optional
        Maps the field of a scale, with its number and parameters, to one measured as part of a larger image.

    Raises
    ------
    ValueError
        When the image has no edges in the regions of interest, allows fewer scales than `parameters` asks for, or needs
        more memory than is free.
    """

    def __init__(
        self,
        values: ArrayLike | Image,
        parameters: Parameters | str | None = None,
        regions: AnyRegions | None = None,
        measured: FieldMeasure | None = None,
    ) -> None:
        parameters = choose_parameters(parameters, Parameters())
        self._measured = measured
        self.image = as_image(values)
        shape = self.image.shape
        check_regions(regions, shape)
        darkest, brightest = self.image.gray_range
        if darkest == brightest:
            raise ValueError(
                f"{self.image.source} is constant ({darkest:g} everywhere) and has no edges: "
                "open an image with objects."
            )
        check_field_memory(shape, _MIN_BYTES_PER_PIXEL[len(shape)], self.image.source)
        self.scales = parameters.scales
        self._pitch: Any = pitch_of(self.image.spacing) if len(shape) == 3 else (1.0, 1.0)
        self._sources = SourceImages(self.image, parameters.scales, part=measured is not None)
        self._latest = parameters
        self._set_regions(regions)
        if len(shape) == 3:
            check_volume_parameters(parameters)
        elif math.prod(shape) <= LARGE_IMAGE_PIXELS:  # the fields of all scales at once, side by side
            run_in_parallel(
                lambda first, end: [self._at(scale, parameters) for scale in range(first, end)], self.scales, 1
            )
        if regions is not None:
            self._check_edges()

    def _set_regions(self, regions: AnyRegions | None, free: Any = None) -> None:
        """Set the regions; `free` builds the fields of the same regions of interest."""
        self.regions, self._lock = regions, RLock()
        fields: Any = (
            partial(volume_field_builders, pitch=self._pitch) if self.image.ndim == 3 else plane_field_builders
        )
        self._free, self._at = fields(self._sources, regions=regions, free=free)
        if self._measured is not None:
            plain, measured = self._at, self._measured
            self._at = lru_cache(self.scales)(lambda scale, given: measured(plain(scale, given), scale, given))
        self._charged = lru_cache(_KEPT_CHARGED_FIELDS)(partial(add_charges, self.image.shape))

    def with_regions(self, regions: AnyRegions | None) -> Self:
        """Return these fields with other regions of interest and barriers, and as many scales.

        With other barriers only, no field is built again; with other regions of interest the image gradient is taken
        over. A state of a run in the previous regions can be stepped in the new ones.

        Raises
        ------
        ValueError
            When the image has no edges in the regions of interest, or one of them contains no pixel.
        """
        others = regions is not None and (self.regions is None or regions.interest != self.regions.interest)
        if others:
            check_regions(regions, self.image.shape)
        same = (regions.interest if regions else ()) == (self.regions.interest if self.regions else ())
        other = copy_with(self)
        other._set_regions(regions, self._free if same else None)
        if others:
            other._check_edges()
        return other

    def scale_field(self, parameters: Parameters, scale: int = 0) -> ScaleField:
        """Return the fields of a scale, built on first use; a `VolumeField` in a volume."""
        self._latest = parameters
        with self._lock:
            found: ScaleField = self._at(scale, parameters)
        return found

    def _field_with(self, field: ScaleField, scale: int, charges: Charges) -> ScaleField:
        """Return a scale field with placed charges; in a volume, where particles feel these directly, the field."""
        return field if not charges or self.image.ndim == 3 else self._charged(field, scale, charges)

    def edge_map(self, parameters: Parameters, scale: int = 0) -> Array:
        """Return the edge map of a scale, shape (H, W), zero where the edge floor leaves no fixed charge."""
        return self.scale_field(parameters, scale).fixed_charges

    def force_field(self, parameters: Parameters, scale: int = 0, charges: Sequence[PlacedCharge] = ()) -> Array:
        """Return the Lorentz force on the pixels of a scale, shape (2, H, W), with that of placed charges.

        Without charges the vectors have at most unit length. The charges are in px of the image, at every scale.
        """
        field, radius = self.scale_field(parameters, scale), charge_radius_at(scale)
        force: Any = np.array(field.lorentz)
        placed = self._charges_at_scale(charges, scale)
        for window, places in windows_near_charges(placed, radius, field.shape, self._pitch):
            force[(slice(None), *window)] += np.moveaxis(placed_forces(placed, radius, places), -1, 0)
        found: Array = force
        return found

    def potential(self, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Array:
        """Return the potential on the pixels of the image, shape (H, W) [gray levels], lowest where it attracts most.

        The sum of the potential of the fixed charges, eq. (7), which is computed on first use and kept with the field,
        and of the potential of placed charges, whose unit of force counts as the mean slope of the former.
        """
        field, placed = self.scale_field(parameters), self._charges_at_scale(charges, 0)
        potential = field.potential.copy()
        for window, places in windows_near_charges(placed, charge_radius_at(0), field.shape, self._pitch):
            potential[window] += field.slope * placed_potential(placed, charge_radius_at(0), places)
        return potential

    def _charges_at_scale(self, charges: Sequence[PlacedCharge], scale: int) -> Array:
        """Return the position of each charge at a scale, and its strength; shape (K, D + 1)."""
        return charges_at_scale(check_charges(charges, self.image.ndim), scale, self.image.shape) * (*self._pitch, 1.0)

    def __reduce__(self) -> tuple[Any, ...]:
        # the fields, of a hundred bytes a pixel, are computed again
        return type(self), (self.image, replace(self._latest, scales=self.scales), self.regions, self._measured)

    def _check_edges(self) -> None:
        if not self.scale_field(self._latest).edge_map.any():
            raise ValueError("there are no edges in the regions of interest: draw them around the objects.")
