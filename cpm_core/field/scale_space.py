"""The scale space of an image: the fields of each of its scales, built on first use.

A scale field depends on what its edges are taken from (gray levels in their tone or a vessel measure, cleaned if
asked), the edge floor and the largest width of the image border. With another edge floor or border only the field is
built again, with another smoothing also the gradient. The barriers do not depend on parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from threading import RLock
from typing import Any, Literal, NamedTuple

import numpy as np

from cpm_core.field.edge_map import automatic_smoothing, prepared
from cpm_core.field.scale_field import LARGE, ScaleField, Slopes, build_scale_field, slopes_of
from cpm_core.image.colors import LUMINANCE
from cpm_core.image.denoising import Cleaned
from cpm_core.image.gray_levels import toned
from cpm_core.image.image import Image
from cpm_core.image.pyramid import check_scales, pyramid, shape_of_scale
from cpm_core.image.regions import NO_BARRIERS, BarrierMap, Regions, build_barrier_map
from cpm_core.image.vesselness import vesselness
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters

_KEPT_SETTINGS = 2
"""Settings whose images and fields are kept, so that a return to the last one costs nothing."""

_KEPT_LARGE = 2
"""Fields of a large image that are kept: that of the scale of a run, and that of the image itself."""

_Gamma = float | Literal["auto"]
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
    """What the edges of an image are taken from at its scales, for any parameters; threads may share it.

    Attributes
    ----------
    scales, shape : int, tuple of int
        How many scales there are, and the shape of the image.
    at : callable
        Gives the `Source` of a scale, from what to take edges and how, and the smoothing.
    slopes : callable
        Gives the `Slopes` of a source after its smoothing.
    """

    def __init__(self, image: Image, scales: int) -> None:
        check_scales(scales, image.shape)
        self.scales, self.shape = scales, image.shape
        lock = RLock()
        large = math.prod(image.shape) > LARGE  # it stays in the few bytes of its file

        @lru_cache(_KEPT_SETTINGS)
        def images_of(channel: str, edges: str, gamma: _Gamma) -> tuple[Array, ...]:  # not before the image is seen
            own = image.colors is None or channel == LUMINANCE
            given = image.gray(channel) if not own else image.stored if large else image.values
            if not own and given.min() == given.max():
                raise ValueError(
                    f"The channel {channel} is the same everywhere and has no edges: choose another channel."
                )
            values = toned(given, gamma)
            if edges == "vessels":
                values = vesselness(values.astype(np.float64, copy=False))
            return pyramid(values, scales)

        @lru_cache(_KEPT_SETTINGS)
        def cleaned_of(channel: str, edges: str, gamma: _Gamma) -> tuple[tuple[Array, ...], Cleaned]:
            images = images_of(channel, edges, gamma)
            given = images[0].astype(np.float64, copy=False)
            ready = prepared(given)
            return images if ready.image is given else pyramid(ready.image, scales), ready

        @lru_cache(_KEPT_SETTINGS * scales)
        def at(scale: int, channel: str, edges: str, gamma: _Gamma, smoothing: _Gamma) -> Source:
            of = image.channel(channel), edges, gamma
            with lock:
                images = images_of(*of)
                if smoothing != "auto":
                    return Source(images[scale], smoothing, 0.0)
                clean, ready = cleaned_of(*of)
                # a cleaned image needs the same smoothing at all scales
                same = scale == 0 or clean is not images
                return Source(clean[scale], ready.sigma if same else automatic_smoothing(clean[scale]), ready.floor)

        @lru_cache(_KEPT_SETTINGS * scales)
        def slope_of(*key: Any) -> Slopes:
            found = at(*key)
            return slopes_of(found.values, found.smoothing)

        self.at, self.slopes = at, slope_of


def plane_fields(
    sources: SourceImages, regions: Regions | None, free: Free | None = None
) -> tuple[Free, Callable[[int, Parameters], ScaleField]]:
    """Functions that build the fields of an image without barriers, and with them for parameters at a scale.

    `free` is the first of them where there is one for the same regions of interest.
    """
    scales, shape = sources.scales, sources.shape
    kept = lru_cache(_KEPT_SETTINGS * scales if math.prod(shape) <= LARGE else _KEPT_LARGE)

    @kept
    def build(scale: int, edge_floor: float, max_border: float, exponent: float, *key: Any) -> ScaleField:
        source = sources.at(scale, *key)
        interest = regions and Regions(regions.interest).at_scale(scale, shape)
        floor, slope = max(edge_floor, source.floor), sources.slopes(scale, *key)
        return build_scale_field(
            source.values, source.smoothing, floor, interest, max_border, exponent, slope, NO_BARRIERS
        )

    @lru_cache(scales)
    def barriers(scale: int) -> BarrierMap:
        barred = regions and regions.at_scale(scale, shape)
        return build_barrier_map(barred, shape_of_scale(shape, scale)) if barred else NO_BARRIERS

    known = free or build
    fields = kept(lambda scale, *key: known(scale, *key).with_barriers(barriers(scale)))

    def at(scale: int, parameters: Parameters) -> ScaleField:
        own = parameters.channel, parameters.edges, parameters.gamma, parameters.smoothing
        return fields(scale, parameters.edge_floor, parameters.max_border, parameters.exponent_in(2), *own)

    return known, at
