"""The scale space of an image: the fields of each of its scales, built on first use.

A scale field depends on what its edges are taken from (gray levels in their tone or a vessel measure, cleaned if
asked), the edge floor and the largest width of the image border. With another edge floor or border only the field is
built again, with another smoothing also the gradient. The barriers do not depend on parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from functools import lru_cache, partial
from threading import RLock
from typing import Literal, NamedTuple

import numpy as np

from cpm_core.field.edge_map import automatic_smoothing, gradient, prepared
from cpm_core.field.scale_field import LARGE, ScaleField, build_scale_field
from cpm_core.image.colors import Colors, channel_of
from cpm_core.image.denoising import Cleaned
from cpm_core.image.gray_levels import toned
from cpm_core.image.pyramid import pyramid
from cpm_core.image.regions import NO_BARRIERS, BarrierMap, Line, Regions, build_barrier_map
from cpm_core.image.vesselness import vesselness
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters

_KEPT_SETTINGS = 2
"""Settings whose images and fields are kept, so that a return to the last one costs nothing."""

_Gamma = float | Literal["auto"]
_Images = tuple[Array, ...]


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
    r"""The images of an image of shape (\*shape) at `scales` scales, for any parameters; threads may share it.

    `image` is its luminance where it has `colors`, whose channels are taken if asked. Each is made on first use.
    """

    def __init__(self, image: Array, scales: int, colors: Colors | None = None) -> None:
        self.original = pyramid(image, scales)
        self._images = lru_cache(_KEPT_SETTINGS)(partial(_images_of, self.original, colors))
        self._cleaned = lru_cache(_KEPT_SETTINGS)(partial(_cleaned_of, self._images))
        self._sigma = lru_cache(_KEPT_SETTINGS * scales)(partial(_sigma_of, self._images, self._cleaned))
        self._channels = colors is not None
        self._lock = RLock()

    def at(self, scale: int, channel: str, edges: str, gamma: _Gamma, smoothing: _Gamma) -> Source:
        """Source of a scale."""
        of = channel if self._channels else "luminance", edges, gamma
        with self._lock:
            if smoothing != "auto":
                return Source(self._images(*of)[scale], smoothing, 0.0)
            images, cleaned = self._cleaned(*of)
            return Source(images[scale], self._sigma(scale, *of), cleaned.floor)


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


class ScaleSpace:
    r"""Scale fields of an image, shape (\*shape), for any parameters; threads may share it.

    `scales` is the number of scales; `regions` holds regions of interest and barriers in px of the image;
    `colors` those of a color image, whose luminance `image` is.
    """

    def __init__(self, image: Array, scales: int, regions: Regions | None = None, colors: Colors | None = None) -> None:
        self._sources = SourceImages(image, scales, colors)
        self._gradient = lru_cache(_KEPT_SETTINGS * scales)(partial(_gradient_of, self._sources))
        self._limit(regions, None)

    def _limit(self, regions: Regions | None, known: Callable[..., ScaleField] | None) -> None:
        """Take other regions; `known` has the fields of the same regions of interest."""
        kept = lru_cache(_KEPT_SETTINGS * len(self))
        self._regions, self._lock = regions, RLock()
        self._free = known or kept(partial(_field_of, self._sources, self._gradient, regions))
        barriers = lru_cache(len(self))(partial(_barriers_of, self._sources, regions))
        self._fields = kept(partial(_barred, self._free, barriers))

    def with_regions(self, regions: Regions | None) -> ScaleSpace:
        """Scale space of the same image with other regions.

        With the same regions of interest all scale fields are taken over, except for the barriers; with other ones,
        only what does not depend on them.
        """
        other = copy(self)
        other._limit(regions, self._free if _interest(regions) == _interest(self._regions) else None)
        return other

    def __len__(self) -> int:
        return len(self._sources.original)

    def at(self, scale: int, parameters: Parameters) -> ScaleField:
        """Scale field; of the parameters it depends on those that invalidate the field."""
        with self._lock:
            return self._fields(*_key(scale, parameters))

    def prepare(self, parameters: Parameters) -> None:
        """Build the fields of all scales at once, side by side; of a large image nothing, until a run needs it."""
        if self._sources.original[0].size > LARGE:
            return
        keys = [_key(scale, parameters) for scale in range(len(self))]
        with self._lock:
            self._sources.at(*keys[0][:5])  # once, before the scales are shared among the cores
            share(lambda first, end: [self._fields(*key) for key in keys[first:end]], len(keys), 1)


def _interest(regions: Regions | None) -> tuple[Line, ...]:
    return regions.interest if regions is not None else ()


def _key(scale: int, parameters: Parameters) -> tuple[int, str, str, _Gamma, _Gamma, float, float, float]:
    """What a scale field depends on: first where and what its edges are taken from."""
    own = parameters.channel, parameters.edges, parameters.gamma, parameters.smoothing
    return scale, *own, parameters.edge_floor, parameters.max_border, parameters.exponent_in(2)


def _gradient_of(sources: SourceImages, scale: int, *source: object) -> Array:
    found = sources.at(scale, *source)  # type: ignore[arg-type]
    return gradient(found.values, found.smoothing, np.float32 if found.values.size > LARGE else np.float64)


def _field_of(
    sources: SourceImages,
    slope: Callable[..., Array],
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
        slope(scale, channel, edges, gamma, smoothing),
        NO_BARRIERS,
    )


def _barriers_of(sources: SourceImages, regions: Regions | None, scale: int) -> BarrierMap:
    if regions is None:
        return NO_BARRIERS
    return build_barrier_map(regions.at_scale(scale, sources.original[0].shape), sources.original[scale].shape)


def _barred(
    free: Callable[..., ScaleField], barriers: Callable[[int], BarrierMap], scale: int, *key: object
) -> ScaleField:
    return free(scale, *key).with_barriers(barriers(scale))
