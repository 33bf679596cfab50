"""What is prepared for an image on the worker thread: methods with their seeds, and overlays."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np

from app.model.display.display_image import (
    DisplayImage,
    DisplayVolume,
    display_of_edge_map,
    display_of_potential,
)
from app.model.display.lines import iso_lines
from app.model.document.document import Document
from app.model.document.modes import MODES
from app.model.text.language import tr
from app.model.volume.sampled_volumes import SampledForce, SampledValues
from app.session.exchange.mailbox import Mailbox
from app.session.exchange.messages import Drawn, Overlays, sentence
from cpm_core import METHODS, Contour, Image, Method, Parameters, PlacedCharge
from cpm_core.image import AnyRegions
from cpm_core.medial_axis import SkeletonMethod
from cpm_core.numerics import Array
from cpm_core.parameters import invalidating
from cpm_core.shapes import NO_SEEDS, ImageSeeds, SeedCache


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
        name = MODES[document.mode].method
        image, method = self._sized(document), self._ready.get(name)
        other = method is None or (method.image.spacing, method.image.unit) != (image.spacing, image.unit)
        if method is None or other or not method.suits(document.parameters):
            method = self._makers[name](image, document.parameters, document.regions)
        elif method.regions != document.regions:
            method = method.with_regions(document.regions)
        if image is self._image:
            self.keep(method)
        if isinstance(method, SkeletonMethod) and image.ndim == 3:
            return method.of_objects(document.outlined_surfaces)
        if isinstance(method, SkeletonMethod) and document.outlines:
            return method.of_objects([Contour(np.array(line), closed=True) for line in document.outlines])
        return method

    def _sized(self, document: Document) -> Image:
        """The image with the size of a pixel that it has in a document, whose run may have begun before a change."""
        assert self._image is not None
        return self._image if document.image is None else document.image.sized(self._image)

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


_MOST_VOXELS = 1 << 26
"""Largest volume whose field is worked out, for which it takes 800 MB at a time."""

Overlay = Callable[[Method[Any], Parameters, Sequence[PlacedCharge]], Drawn]


def _edge_map(method: Method[Any], parameters: Parameters, charges: Sequence[PlacedCharge]) -> Drawn:
    found = method.edge_map(parameters)
    shades = display_of_edge_map(found)
    return DisplayVolume(shades) if found.ndim == 3 else DisplayImage.of(shades)


def _potential(method: Method[Any], parameters: Parameters, charges: Sequence[PlacedCharge]) -> Drawn:
    found = method.potential(parameters, charges)
    shades = display_of_potential(found)
    return DisplayVolume(shades) if found.ndim == 3 else DisplayImage.of(shades)


def _iso_lines(method: Method[Any], parameters: Parameters, charges: Sequence[PlacedCharge]) -> Drawn:
    """Lines of equal potential; the values of a volume, in whose slices they are found."""
    found = method.potential(parameters, charges)
    return SampledValues.of(found) if found.ndim == 3 else iso_lines(found)


def _field(method: Method[Any], parameters: Parameters, charges: Sequence[PlacedCharge]) -> Drawn:
    image = method.image
    if math.prod(image.shape) > _MOST_VOXELS:
        raise ValueError(tr("The volume is too large for arrows of the field: open a part of it, or reduce its size."))
    found = method.field(parameters, 0, charges)
    return SampledForce.of(found, image.spacing) if image.ndim == 3 else found


OVERLAYS: Mapping[str, Overlay] = MappingProxyType(
    {
        "edge_map": _edge_map,
        "field": _field,
        "potential": _potential,
        "iso_lines": _iso_lines,
    }
)
"""Display images of the edge map and of the potential, shape (H, W), or (P, R, C) of a volume; electric field of edges
and placed charges, shape (2, H, W); lines of equal potential, shape (M, 2), with a row of NaN after each. Of a volume
the last two are what their slices are made from."""


class OverlayMaker:
    """Computes the requested overlays again when what they depend on has changed."""

    def __init__(self, made: Mailbox[Overlays]) -> None:
        self._made = made
        self._wanted: frozenset[str] = frozenset()
        self._shown: tuple[object, ...] = ()

    def want(self, names: frozenset[str]) -> None:
        """Keep only these up to date."""
        self._wanted, self._shown = names, ()

    def refresh(
        self,
        image_generation: int,
        method: Method[Any] | None,
        parameters: Parameters,
        charges: Sequence[PlacedCharge],
    ) -> None:
        """Compute the requested overlays if they would differ from the last ones; without a method there are none."""
        if method is None or not self._wanted:
            return
        made_of = [getattr(parameters, name) for name in invalidating("field")]
        key = (method, self._wanted, charges, *made_of)
        if key == self._shown:
            return
        arrays, trouble = {}, ""
        for name in self._wanted:
            try:
                arrays[name] = OVERLAYS[name](method, parameters, charges)
            except Exception as error:  # the run does not depend on what is shown over the image
                trouble = sentence(error, tr("preparing what lies over the image"))
        self._made.put(Overlays(image_generation, arrays, trouble))
        self._shown = key
