"""The fields of one image: edge map, Lorentz force and potential at every scale, built on first use."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from typing import Any, Self

from numpy.typing import ArrayLike

from cpm_core.field.placed_charges import PlacedCharge, PlacedChargeCache, VolumeCharges, placed_in
from cpm_core.field.scale_field import ScaleField
from cpm_core.field.scale_space import ScaleSpace
from cpm_core.field.volume_field import VolumeSpace
from cpm_core.image.image import Image, as_image
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import AnyRegions, VolumeRegions
from cpm_core.numerics.memory import check_room
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters

_LEAST_MEMORY = {2: 80.0, 3: 24.0}
"""Memory that no run needs less of, for one pixel [bytes], in the plane and in space; in the plane 106 to 200 are
measured."""


class ImageFields:
    """An image and the fields that act on particles in it.

    Parameters
    ----------
    values : array_like, shape (H, W) or (P, H, W), or Image
        Image or volume.
    parameters : Parameters, optional
        For the number of scales, and the fields to prepare at once.
    regions : Regions or VolumeRegions, optional
        Regions of interest, which particles do not leave, and barriers, which they do not cross; the whole image by
        default.

    Raises
    ------
    ValueError
        When the image has no edges in the regions of interest, allows fewer scales than `parameters` asks for, or needs
        more memory than is free.
    """

    def __init__(
        self, values: ArrayLike | Image, parameters: Parameters | None = None, regions: AnyRegions | None = None
    ) -> None:
        parameters = parameters or Parameters()
        self.image = as_image(values)
        array = self.image.values
        if regions is not None:
            regions.check(array.shape)
        if array.min() == array.max():
            raise ValueError(
                f"{self.image.source} is constant ({array.flat[0]:g} everywhere) and has no edges: "
                "open an image with objects."
            )
        self.regions = regions
        check_room(array.shape, _LEAST_MEMORY[array.ndim], self.image.source)
        self._scale_space = _scale_space_of(self.image, parameters.scales, regions)
        self._scale_space.prepare(parameters)
        self._charged = _charges_of(self.image)
        self._latest = parameters
        if regions is not None:
            self._check_edges()

    def with_regions(self, regions: AnyRegions | None) -> Self:
        """The same with other regions of interest and barriers, and as many scales.

        With other barriers only, no field is built again; with other regions of interest the image gradient is taken
        over. A state of a run in the former regions can be stepped in the new ones.

        Raises
        ------
        ValueError
            When the image has no edges in the regions of interest, or one of them contains no pixel.
        """
        others = regions is not None and (self.regions is None or regions.interest != self.regions.interest)
        if regions is not None and others:
            regions.check(self.image.values.shape)
        other = copy(self)
        other.regions = regions
        other._scale_space = self._scale_space.with_regions(regions)
        other._charged = _charges_of(self.image)
        if others:
            other._check_edges()
        return other

    @property
    def scales(self) -> int:
        """Number of scales."""
        return len(self._scale_space)

    def suits(self, parameters: Parameters) -> bool:
        """Whether a run with these parameters can start in these fields, which have a fixed number of scales."""
        return parameters.scales == self.scales

    def scale_field(self, parameters: Parameters, scale: int = 0) -> ScaleField:
        """Fields of a scale, built on first use; a `VolumeField` in a volume."""
        self._latest = parameters
        found: ScaleField = self._scale_space.at(scale, parameters)
        return found

    def edge_map(self, parameters: Parameters, scale: int = 0) -> Array:
        """Edge map of a scale, shape (H, W), zero where the edge floor leaves no fixed charge."""
        return self.scale_field(parameters, scale).fixed_charges

    def field(self, parameters: Parameters, scale: int = 0, charges: Sequence[PlacedCharge] = ()) -> Array:
        """Lorentz force on the pixels of a scale, shape (2, H, W), with that of placed charges.

        Without charges the vectors have at most unit length. The charges are in px of the image, at every scale.
        """
        force: Array = self._charged.force(
            self.scale_field(parameters, scale), scale, placed_in(charges, self.image.ndim)
        )
        return force

    def potential(self, parameters: Parameters, charges: Sequence[PlacedCharge] = ()) -> Array:
        """Potential on the pixels of the image, shape (H, W) [gray levels], lowest where it attracts particles most.

        The sum of the potential of the fixed charges, eq. (7), which is computed on first use and kept with the field,
        and of the potential of placed charges, whose unit of force counts as the mean slope of the former.
        """
        placed = placed_in(charges, self.image.ndim)
        potential: Array = self._charged.potential(self.scale_field(parameters), placed)
        return potential

    def _check_edges(self) -> None:
        if not self.scale_field(self._latest).edge_map.any():
            raise ValueError("there are no edges in the regions of interest: draw them around the objects.")


def _scale_space_of(image: Image, scales: int, regions: AnyRegions | None) -> Any:
    """The `ScaleSpace` of an image, or the `VolumeSpace` of a volume, which has the same methods."""
    if image.ndim == 3:
        return VolumeSpace(image, scales, regions if isinstance(regions, VolumeRegions) else None)
    return ScaleSpace(image.values, scales, regions if isinstance(regions, Regions) else None, image.colors)


def _charges_of(image: Image) -> Any:
    """The `PlacedChargeCache` of an image, or the `VolumeCharges` of a volume."""
    return VolumeCharges(image.shape) if image.ndim == 3 else PlacedChargeCache(image.shape)
