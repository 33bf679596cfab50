"""The fields of one image for runs whose start decides on the edges that they reach."""

from __future__ import annotations

from typing import Self

from numpy.typing import ArrayLike

from cpm_core.field.scale_field import ScaleField
from cpm_core.image.image import Image
from cpm_core.image.regions import Regions
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.image_fields import ImageFields
from cpm_core.model.state import State
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.segmentation.reach.local_fields import LocalFields
from cpm_core.segmentation.reach.reach_map import ReachMap


class RunFields(ImageFields):
    """`ImageFields`, and those that particles of a run feel."""

    def __init__(
        self, values: ArrayLike | Image, parameters: Parameters | None = None, regions: AnyRegions | None = None
    ) -> None:
        super().__init__(values, parameters, regions)
        self._local_fields = LocalFields(self.scale_field, _of_plane(regions))

    def with_regions(self, regions: AnyRegions | None) -> Self:
        """The same with other regions; see `ImageFields.with_regions`."""
        other = super().with_regions(regions)
        other._local_fields = LocalFields(other.scale_field, _of_plane(regions))
        return other

    def reach_map(self, start: Array, parameters: Parameters) -> ReachMap | None:
        """How a start, shape (N, 2) [px], reaches the edges of the image; None where it does not limit a run."""
        return self._local_fields.map_of(start, parameters)

    def _field_of(self, state: State, parameters: Parameters) -> ScaleField:
        """Fields of the scale of a state, limited to the edges that its start reaches."""
        return self._local_fields.at(state.scale, state.start, parameters)


def _of_plane(regions: AnyRegions | None) -> Regions | None:
    """The regions of an image; None for those of a volume, where a start does not limit a run."""
    return regions if isinstance(regions, Regions) else None
