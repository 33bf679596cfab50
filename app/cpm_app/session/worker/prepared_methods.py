"""Methods with their seeds, and overlays, prepared for an image on the worker thread."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from cpm_app.model.display.display_image import (
    DisplayImage,
    DisplayVolume,
    shade_edge_map,
    shade_potential,
)
from cpm_app.model.document.document import Document
from cpm_app.model.document.modes import MODES
from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import SampledForce
from cpm_app.session.exchange.messages import OverlayData
from cpm_core import RUN_METHODS, Contour, Image, Method, Parameters, PlacedCharge
from cpm_core.medial_axis import SkeletonMethod
from cpm_core.numerics import Array
from cpm_core.numerics.types import NO_POINTS
from cpm_core.shapes import NO_SEEDS, ImageSeeds, SeedCache


class PreparedMethods:
    """Methods by name for the open image: made when a run needs them, and kept as long as the image."""

    def __init__(self) -> None:
        self._ready: dict[str, Method[Any]] = {}
        self._image: Image | None = None
        self._seed_cache: SeedCache | None = None

    def use_image(self, method: Method[Any]) -> None:
        """Change to another image and the method that has been prepared for it."""
        self.change_pixel_size(method.image)
        self.keep_method(method)

    def change_pixel_size(self, image: Image) -> None:
        """Make methods for the same image with another pixel size from now on."""
        self._ready.clear()
        self._image = image
        self._seed_cache = SeedCache(image)

    def keep_method(self, method: Method[Any]) -> None:
        """Keep a method in place of the same one with other regions."""
        self._ready[method.name] = method

    def method_for(self, document: Document) -> Method[Any]:
        """Return the method of a document's mode, in its regions, and for a skeleton of the outlines it is made of."""
        name = MODES[document.mode].method
        image, method = self._image_with_size(document), self._ready.get(name)
        other = method is None or (method.image.spacing, method.image.unit) != (image.spacing, image.unit)
        if method is None or other or not method.can_start(document.parameters):
            method = RUN_METHODS[name](image, document.parameters, document.regions)
        elif method.regions != document.regions:
            method = method.with_regions(document.regions)
        if image is self._image:
            self.keep_method(method)
        if isinstance(method, SkeletonMethod) and image.ndim == 3:
            return method.for_objects(document.outlined_bodies)
        if isinstance(method, SkeletonMethod) and document.outlines:
            return method.for_objects([Contour(np.array(line), closed=True) for line in document.outlines])
        return method

    def _image_with_size(self, document: Document) -> Image:
        """Return the image with the pixel size of a document, whose run may have begun before that was changed."""
        assert self._image is not None
        return self._image if document.image is None else document.image.with_known_pixel_size(self._image)

    def compute_seeds(self, document: Document) -> Array:
        """Return the seeds of a run of a document, shape (N, D) [px]; none if its method needs none."""
        if not RUN_METHODS[MODES[document.mode].method].seeded:
            return NO_POINTS
        return document.collect_seeds(self.compute_image_seeds(document))

    def compute_image_seeds(self, document: Document) -> ImageSeeds:
        """Return the seeds of the starts of a document that depend on the image."""
        if self._seed_cache is None or self._image is None:
            return NO_SEEDS
        image = self._image_with_size(document)
        return document.find_image_seeds(self._seed_cache if image is self._image else SeedCache(image))


_MAX_FIELD_VOXELS = 1 << 26
"""Largest volume whose field is computed, which takes 800 MB for this one [voxels]."""


AREA_OVERLAY = "start_area"
"""Name of the overlay of the area of a start, which depends on the start, not on the image alone."""


def compute_overlay(
    name: str, method: Method[Any], parameters: Parameters, charges: Sequence[PlacedCharge]
) -> OverlayData:
    """Compute an overlay of the image.

    These are display images of the edge map and of the potential, shape (H, W), or (P, R, C) for a volume; and the
    electric `field` of edges and placed charges, shape (2, H, W), for a volume the samples that its slices are made of.
    """
    image = method.image
    deep = image.ndim == 3
    if name == "edge_map":
        shades = shade_edge_map(method.edge_map(parameters))
        return DisplayVolume(shades) if deep else DisplayImage.from_shades(shades)
    if name == "field":
        if math.prod(image.shape) > _MAX_FIELD_VOXELS:
            raise ValueError(
                tr("The volume is too large for arrows of the field: open a part of it, or reduce its size.")
            )
        field = method.force_field(parameters, 0, charges)
        return SampledForce.from_force(field, image.spacing) if deep else field
    shades = shade_potential(method.potential(parameters, charges))
    return DisplayVolume(shades) if deep else DisplayImage.from_shades(shades)
