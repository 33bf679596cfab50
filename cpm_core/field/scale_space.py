"""The scale space of an image: the fields of each of its scales, built on first use.

A scale field depends on what its edges are taken from (gray levels in their tone or a vessel measure, cleaned if
asked), the edge floor and the largest width of the image border. With another edge floor or border only the field is
built again, with another smoothing also the gradient. The barriers do not depend on parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from threading import RLock
from typing import Literal, NamedTuple

import numpy as np

from cpm_core.field.edge_map import automatic_smoothing, gradient, prepared
from cpm_core.field.scale_field import LARGE, ScaleField, build_scale_field
from cpm_core.image.colors import Colors, channel_of
from cpm_core.image.denoising import Cleaned
from cpm_core.image.gray_levels import toned
from cpm_core.image.image import Image
from cpm_core.image.pyramid import pyramid
from cpm_core.image.regions import NO_BARRIERS, BarrierMap, Regions, build_barrier_map
from cpm_core.image.vesselness import vesselness
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters

_KEPT_SETTINGS = 2
"""Settings whose images and fields are kept, so that a return to the last one costs nothing."""

_Gamma = float | Literal["auto"]
_Images = tuple[Array, ...]
Free = Callable[..., ScaleField]
"""Builds a field without barriers from a scale and the values that it depends on."""


class Source(NamedTuple):
    r"""What the edges of a scale are taken from.

    Attributes
    ----------
    values : ndarray, shape (\*shape)
        Image at the scale.
    smoothing : float
        Gaussian before the gradient [px].
    floor : float
        Edge floor that the noise left by the cleaning needs, as a fraction of the largest edge strength.
    """

    values: Array
    smoothing: float
    floor: float


class SourceImages:
    """What the edges of an image are taken from at its scales, for any parameters; threads may share it."""

    def __init__(self, image: Image, scales: int) -> None:
        self.original = pyramid(image.values, scales)
        self._images = lru_cache(_KEPT_SETTINGS)(partial(_images_of, self.original, image.colors))
        self._cleaned = lru_cache(_KEPT_SETTINGS)(partial(_cleaned_of, self._images))
        self._sigma = lru_cache(_KEPT_SETTINGS * scales)(partial(_sigma_of, self._images, self._cleaned))
        self.gradient = lru_cache(_KEPT_SETTINGS * scales)(self._gradient_of)
        self._channels = image.colors is not None
        self._lock = RLock()

    def at(self, scale: int, channel: str, edges: str, gamma: _Gamma, smoothing: _Gamma) -> Source:
        """Source of a scale."""
        of = channel if self._channels else "luminance", edges, gamma
        with self._lock:
            if smoothing != "auto":
                return Source(self._images(*of)[scale], smoothing, 0.0)
            images, cleaned = self._cleaned(*of)
            return Source(images[scale], self._sigma(scale, *of), cleaned.floor)

    def _gradient_of(self, scale: int, channel: str, edges: str, gamma: _Gamma, smoothing: _Gamma) -> Array:
        found = self.at(scale, channel, edges, gamma, smoothing)
        return gradient(found.values, found.smoothing, np.float32 if found.values.size > LARGE else np.float64)


def _images_of(original: _Images, colors: Colors | None, channel: str, edges: str, gamma: _Gamma) -> _Images:
    """An image at all scales; ValueError when a channel is the same everywhere."""
    values = channel_of(original[0], colors, channel)
    if values is not original[0] and values.min() == values.max():
        raise ValueError(f"The channel {channel} is the same everywhere and has no edges: choose another channel.")
    values = toned(values, gamma)
    if edges == "vessels":
        values = vesselness(values)
    return original if values is original[0] else pyramid(values, len(original))


def _cleaned_of(of: Callable[..., _Images], *key: object) -> tuple[_Images, Cleaned]:
    """An image as the automatic smoothing prepares it, at all scales."""
    images = of(*key)
    ready = prepared(images[0])
    return images if ready.image is images[0] else pyramid(ready.image, len(images)), ready


def _sigma_of(
    of: Callable[..., _Images], cleaned: Callable[..., tuple[_Images, Cleaned]], scale: int, *key: object
) -> float:
    """Sigma of the automatic smoothing at a scale [px]."""
    images, ready = cleaned(*key)
    if scale == 0 or images is not of(*key):  # a cleaned image needs the same smoothing at all scales
        return ready.sigma
    return automatic_smoothing(images[scale])


def plane_fields(
    sources: SourceImages, regions: Regions | None, free: Free | None = None
) -> tuple[Free, Callable[[int, Parameters], ScaleField]]:
    """Functions that build the fields of an image without barriers, and with them for parameters at a scale.

    `free` is the first of them where there is one for the same regions of interest.
    """
    scales = len(sources.original)
    kept = lru_cache(_KEPT_SETTINGS * scales)
    barriers = lru_cache(scales)(partial(_barriers_of, sources, regions))
    known = free or kept(partial(_field_of, sources, regions))
    fields = kept(lambda scale, *key: known(scale, *key).with_barriers(barriers(scale)))

    def at(scale: int, parameters: Parameters) -> ScaleField:
        own = parameters.channel, parameters.edges, parameters.gamma, parameters.smoothing
        return fields(scale, *own, parameters.edge_floor, parameters.max_border, parameters.exponent_in(2))

    return known, at


def _field_of(
    sources: SourceImages,
    regions: Regions | None,
    scale: int,
    channel: str,
    edges: str,
    gamma: _Gamma,
    smoothing: _Gamma,
    edge_floor: float,
    max_border: float,
    exponent: float,
) -> ScaleField:
    """Scale field without barriers."""
    source = sources.at(scale, channel, edges, gamma, smoothing)
    return build_scale_field(
        source.values,
        source.smoothing,
        max(edge_floor, source.floor),
        regions and Regions(regions.interest).at_scale(scale, sources.original[0].shape),
        max_border,
        exponent,
        sources.gradient(scale, channel, edges, gamma, smoothing),
        NO_BARRIERS,
    )


def _barriers_of(sources: SourceImages, regions: Regions | None, scale: int) -> BarrierMap:
    if regions is None:
        return NO_BARRIERS
    return build_barrier_map(regions.at_scale(scale, sources.original[0].shape), sources.original[scale].shape)
