"""The document: everything that the user has set; small, frozen, undoable."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from dataclasses import field
from pathlib import Path
from typing import Literal

from cpm_app.model.text.language import tr
from cpm_core import PARAMETERS, PRESETS, Image, Parameters, PlacedCharge
from cpm_core.formats import ImageFile, Reading
from cpm_core.formats.images import resolution
from cpm_core.formats.images.reading import DEFAULT_READING
from cpm_core.image import AnyRegions
from cpm_core.image.region import Region
from cpm_core.medial_axis import SkeletonTarget
from cpm_core.numerics.types import Array, Extent, Line, Sides, frozen
from cpm_core.objects.segmented import SegmentedObjects
from cpm_core.pages import limit_scales
from cpm_core.shapes import (
    NO_SEEDS,
    ImageSeeds,
    ImageStart,
    Interest,
    Points,
    SeedCache,
    Shape,
    Start,
    collect_charges,
    collect_regions,
    collect_seeds,
    select_starts,
)

Mode = Literal["shape", "automatic", "skeleton", "published"]
"""Purpose of a run; see `cpm_app.model.document.modes`."""

_NOTHING_TO_START_FROM = tr(
    "There is nothing to start from: draw a circle, a stroke or points on the image first, or start everywhere."
)
"""Error of a run without a start on an image."""

_NOTHING_TO_START_FROM_IN_VOLUME = tr(
    "There is nothing to start from: draw a sphere, a box, a stroke or points in a slice of the volume first."
)
"""Error of a run without a start in a volume."""


@frozen
class ImageReference:
    """The image of a document without its gray values: name, file, shape, contrast and SHA-256 of the file.

    The contrast is the largest minus the smallest gray value; the hash is empty where it is not known. `spacing` is the
    size of a pixel along rows and columns in `unit`, which is None where the image gives none. `reading` says which
    part of the file it is.
    """

    name: str
    path: str
    shape: Extent
    contrast: float
    sha256: str = ""
    spacing: Sides = (1.0, 1.0)
    unit: str | None = None
    reading: Reading = DEFAULT_READING

    @classmethod
    def from_image(cls, path: Path, image: Image, reading: Reading = DEFAULT_READING) -> ImageReference:
        """Refer to an image that has been read from a file."""
        low, high = image.gray_range
        return cls(path.name, str(path), image.shape, high - low, image.file_sha256, image.spacing, image.unit, reading)

    def with_known_pixel_size(self, image: Image) -> Image:
        """Return the image with the size of a pixel that is known here."""
        if (image.spacing, image.unit) == (self.spacing, self.unit):
            return image
        factor = resolution.conversion_factor(image.unit, self.unit) if image.unit and self.unit else 1.0
        return image.with_spacing(self.spacing, self.unit, factor)

    @property
    def is_volume(self) -> bool:
        """Whether it has planes, rows and columns."""
        return len(self.shape) == 3


@frozen
class Document:
    """An image, the shapes drawn on it and the parameters of the run.

    Attributes
    ----------
    image : ImageReference or None
        None until the first image is open.
    shapes : tuple of Shape
        The initialization, regions of interest, barriers and placed charges, in the order drawn.
    parameters : Parameters
        Parameters of the model.
    mode : {"shape", "automatic", "skeleton", "published"}
        Purpose of the run.
    objects : SegmentedObjects
        The objects that have been selected, and the selection that is being made.
    outlined : SkeletonTarget
        Objects and contours whose skeleton is wanted in the mode of skeletons; if empty, that of the image.
    second : ImageFile or None
        A second image, which is shown over the first.
    """

    image: ImageReference | None = None
    shapes: tuple[Shape, ...] = ()
    parameters: Parameters = PRESETS["shape"]
    mode: Mode = "shape"
    objects: SegmentedObjects = field(default_factory=SegmentedObjects)
    outlined: SkeletonTarget = field(default_factory=SkeletonTarget)
    second: ImageFile | None = None

    @property
    def starts(self) -> tuple[Start, ...]:
        """The shapes that give particles; a run needs at least one."""
        return select_starts(self.shapes)

    @property
    def image_starts(self) -> tuple[ImageStart, ...]:
        """The starts whose seeds depend on the image."""
        return tuple(shape for shape in self.shapes if isinstance(shape, ImageStart))

    @property
    def seeding_inputs(self) -> tuple[object, ...]:
        """Everything that the seeds of `image_starts` depend on; empty if there are none."""
        if not self.image_starts:
            return ()
        limits = tuple(shape for shape in self.shapes if isinstance(shape, Interest))
        followed = any(start.follows_smoothing for start in self.image_starts)
        barriers = self.objects.barriers
        smoothing = self.parameters.smoothing if followed else None
        return (self.image, self.image_starts, limits, barriers, self.parameters.channel, smoothing)

    def find_image_seeds(self, cache: SeedCache) -> ImageSeeds:
        """Find the seeds of `image_starts` through the cache of an image."""
        seen = self.parameters
        return cache.seeds_for(self.image_starts, seen.smoothing, self.regions, seen.channel)

    def fit_scales(self, parameters: Parameters) -> Parameters:
        """Return the parameters with no more scales than the image has room for."""
        return parameters if self.image is None else limit_scales(parameters, self.image.shape)

    @property
    def regions(self) -> AnyRegions | None:
        """Regions of interest and barriers, boundaries of frozen objects among them; None if there are none."""
        return collect_regions(self.shapes, self.objects.barriers)

    @property
    def outlines(self) -> tuple[Line, ...]:
        """Closed lines whose skeleton is wanted: current boundaries of objects, and closed contours."""
        chosen = self.outlined.objects
        lines = [line for item in self.objects.items if item.number in chosen for line in item.region.boundary]
        return (*lines, *self.outlined.contours)

    @property
    def outlined_bodies(self) -> tuple[Region, ...]:
        """Current bodies of objects in a volume whose skeleton is wanted."""
        chosen = self.outlined.objects
        items = (item for item in self.objects.items if item.number in chosen)
        return tuple(item.region for item in items if item.region.ndim == 3)

    @property
    def skeleton_inputs(self) -> tuple[object, ...]:
        """Everything but the image and the parameters that a skeleton depends on."""
        return self.outlines, self.outlined_bodies, () if self.regions is None else self.regions.interest

    def collect_seeds(self, image_seeds: ImageSeeds = NO_SEEDS) -> Array:
        """Collect the seeds of the starts, shape (N, D) [px of the image], given those of each of `image_starts`.

        ValueError when there is no start.
        """
        if not self.starts:
            raise ValueError(self.nothing_to_start_from)
        return collect_seeds(self.shapes, image_seeds)

    @property
    def has_volume(self) -> bool:
        """Whether its image is a volume."""
        return self.image is not None and self.image.is_volume

    @property
    def nothing_to_start_from(self) -> str:
        """Error of a run without a start."""
        return _NOTHING_TO_START_FROM_IN_VOLUME if self.has_volume else _NOTHING_TO_START_FROM

    @property
    def charges(self) -> tuple[PlacedCharge, ...]:
        """The placed charges, as the engine takes them."""
        return collect_charges(self.shapes)

    @property
    def start_counts(self) -> Counter[Hashable]:
        """Number of times each source of particles occurs: each point separately, every other start as a whole."""
        found: Counter[Hashable] = Counter()
        for start in self.starts:
            found.update(start.positions if isinstance(start, Points) else (start,))
        return found

    @property
    def start_inputs(self) -> tuple[object, ...]:
        """Image and the parameters that take effect only when a run starts."""
        acting = (getattr(self.parameters, name) for name, info in PARAMETERS.items() if info.invalidates == "run")
        return (self.image, *acting)
