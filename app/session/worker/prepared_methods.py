"""The methods that are prepared for an image, and their seeds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from app.model.document.document import Document, ImageReference
from app.model.document.modes import MODES
from cpm_core.contours.contour import Contour
from cpm_core.formats.images import resolution
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.medial_axis.skeleton_method import SkeletonMethod
from cpm_core.medial_axis.space.steps import VolumeSkeletonMethod
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.segmentation.method import METHODS, Method
from cpm_core.shapes.image_starts import NO_SEEDS, ImageSeeds, SeedCache


class PreparedMethods:
    """Methods by name for the image that is open: made when a run needs them, and kept as long as the image."""

    def __init__(self, makers: Mapping[str, Callable[[Image, Parameters, AnyRegions | None], Method[Any]]]) -> None:
        self._makers = makers
        self._ready: dict[str, Method[Any]] = {}
        self._image: Image | None = None
        self._seed_cache: SeedCache | None = None

    def use(self, method: Method[Any]) -> None:
        """Change to another image and the one method that is prepared for it."""
        self._ready = {method.name: method}
        self._image = method.image
        self._seed_cache = SeedCache(method.image)

    def rescale(self, image: Image) -> None:
        """Make methods from now on for the same image with another size of a pixel."""
        self._ready.clear()
        self._image = image
        self._seed_cache = SeedCache(image)

    def keep(self, method: Method[Any]) -> None:
        """Keep a method in place of the same one with other regions."""
        self._ready[method.name] = method

    def method(self, document: Document) -> Method[Any]:
        """The method of a document's mode, in its regions, and for the outlines that it has a skeleton of."""
        assert self._image is not None
        name = MODES[document.mode].method
        image, method = self._sized(document), self._ready.get(name)
        if method is None or _size(method.image) != _size(image) or not method.suits(document.parameters):
            method = self._makers[name](image, document.parameters, document.regions)
        elif method.regions != document.regions:
            method = method.with_regions(document.regions)
        if _size(image) == _size(self._image):
            self.keep(method)
        if isinstance(method, VolumeSkeletonMethod):
            return method.of_surfaces(document.outlined_surfaces)
        if isinstance(method, SkeletonMethod) and document.outlines:
            return method.of_outlines([Contour(np.array(line), closed=True) for line in document.outlines])
        return method

    def _sized(self, document: Document) -> Image:
        """The image with the size of a pixel that it has in a document, whose run may have begun before a change."""
        image, known = self._image, document.image
        assert image is not None
        if known is None or _size(known) == _size(image):
            return image
        factor = resolution.factor(image.unit, known.unit) if image.unit and known.unit else 1.0
        return image.sized(known.spacing, known.unit, factor)

    def seeds(self, document: Document) -> Array:
        """Seeds of a run of a document, shape (N, 2) [px]; none if its method needs none."""
        if not METHODS[MODES[document.mode].method].seeded:
            return np.zeros((0, 2))
        return document.seeds(self.image_seeds(document))

    def image_seeds(self, document: Document) -> ImageSeeds:
        """Seeds of the starts of a document that depend on the image."""
        if self._seed_cache is None or self._image is None:
            return NO_SEEDS
        image, seen = self._sized(document), document.parameters
        cache = self._seed_cache if image is self._image else SeedCache(image)
        return cache.seeds_for(document.image_starts, seen.smoothing, document.regions, seen.channel)


def _size(image: Image | ImageReference) -> tuple[object, ...]:
    return image.spacing, image.unit
