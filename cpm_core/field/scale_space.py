"""The scale space of an image: the fields of each of its scales, built on first use.

A scale field depends on the source of its edges (toned gray levels or a vessel measure, cleaned if requested), the
edge floor and the largest width of the image border. With another edge floor or border only the field is
built again, with another smoothing also the gradient. The barriers do not depend on parameters.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from threading import RLock
from typing import Any, Literal, NamedTuple

import numpy as np

from cpm_core.field.edge_map import automatic_smoothing, prepare_for_edges
from cpm_core.field.scale_field import (
    LARGE_IMAGE_PIXELS,
    ScaleField,
    WindowGradient,
    build_scale_field,
    gradient_provider,
)
from cpm_core.image.colors import LUMINANCE_CHOICE
from cpm_core.image.denoising import DenoisedImage
from cpm_core.image.gray_levels import apply_gamma, limit_specks
from cpm_core.image.image import Image
from cpm_core.image.pyramid import build_pyramid, check_scales, shape_at_scale
from cpm_core.image.regions import NO_BARRIERS, BarrierMap, Regions, build_barrier_map
from cpm_core.image.vesselness import compute_vesselness
from cpm_core.numerics.types import Array, copy_with
from cpm_core.parameters import Parameters

_KEPT_SETTINGS = 2
"""Number of settings whose images and fields are kept, so that a return to the last one costs nothing."""

_KEPT_LARGE = 2
"""Number of fields of a large image that are kept: at the scale of a run, and at full size."""

_Gamma = float | Literal["auto"]
PlaneFieldBuilder = Callable[..., ScaleField]
"""Builds a field without barriers from a scale and the values that it depends on."""


class EdgeSource(NamedTuple):
    r"""Image at a scale from which edges are taken.

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
    """Images from which edges are taken at each scale, for any parameters; threads may share it.

    A `part` of a larger image has gray levels that are limited already to those that count in the whole.

    Attributes
    ----------
    scales, shape : int, tuple of int
        How many scales there are, and the shape of the image.
    source_at : callable
        Returns the `EdgeSource` of a scale for the channel, the kind of edges, the tone and the smoothing.
    slopes : callable
        Returns the `WindowGradient` of a source after its smoothing.
    """

    def __init__(self, image: Image, scales: int, part: bool = False) -> None:
        check_scales(scales, image.shape)
        self.scales, self.shape = scales, image.shape
        lock = RLock()
        large = math.prod(image.shape) > LARGE_IMAGE_PIXELS  # it stays in the few bytes of its file

        @lru_cache(_KEPT_SETTINGS)
        def build_images(channel: str, edges: str, gamma: _Gamma) -> tuple[Array, ...]:  # not before the image is shown
            """Return the image at each scale, shape (H, W), in its tone or as a vessel measure."""
            own = image.colors is None or channel == LUMINANCE_CHOICE
            given = image.gray_levels(channel) if not own else image.stored if large else image.values
            if not own and given.min() == given.max():
                raise ValueError(
                    f"The channel {channel} is the same everywhere and has no edges: choose another channel."
                )
            values = apply_gamma(given if part else limit_specks(given), gamma)
            if edges == "vessels":
                values = compute_vesselness(values.astype(np.float64, copy=False))
            return build_pyramid(values, scales)

        @lru_cache(_KEPT_SETTINGS)
        def clean_images(channel: str, edges: str, gamma: _Gamma) -> tuple[tuple[Array, ...], DenoisedImage]:
            """Return the cleaned image at each scale, shape (H, W), and how it was cleaned."""
            images = build_images(channel, edges, gamma)
            given = images[0].astype(np.float64, copy=False)
            ready = prepare_for_edges(given)
            return images if ready.image is given else build_pyramid(ready.image, scales), ready

        @lru_cache(_KEPT_SETTINGS * scales)
        def source_at(scale: int, channel: str, edges: str, gamma: _Gamma, smoothing: _Gamma) -> EdgeSource:
            of = image.resolve_channel(channel), edges, gamma
            with lock:
                images = build_images(*of)
                if smoothing != "auto":
                    return EdgeSource(images[scale], smoothing, 0.0)
                clean, ready = clean_images(*of)
                # a cleaned image needs the same smoothing at all scales
                same = scale == 0 or clean is not images
                return EdgeSource(clean[scale], ready.sigma if same else automatic_smoothing(clean[scale]), ready.floor)

        @lru_cache(_KEPT_SETTINGS * scales)
        def slopes_at(*key: Any) -> WindowGradient:
            found = source_at(*key)
            return gradient_provider(found.values, found.smoothing)

        self.source_at, self.slopes = source_at, slopes_at


def plane_field_builders(
    sources: SourceImages, regions: Regions | None, free: PlaneFieldBuilder | None = None
) -> tuple[PlaneFieldBuilder, Callable[[int, Parameters], ScaleField]]:
    """Make the functions that build the fields of an image without barriers, and with them for parameters at a scale.

    `free` is the first function, if there is one for the same regions of interest.
    """
    scales, shape = sources.scales, sources.shape
    kept = lru_cache(_KEPT_SETTINGS * scales if math.prod(shape) <= LARGE_IMAGE_PIXELS else _KEPT_LARGE)

    @kept
    def build_field(scale: int, edge_floor: float, max_border: float, exponent: float, *key: Any) -> ScaleField:
        source = sources.source_at(scale, *key)
        interest = regions and Regions(regions.interest).at_scale(scale, shape)
        floor, slope = max(edge_floor, source.floor), sources.slopes(scale, *key)
        return build_scale_field(
            source.values, source.smoothing, floor, interest, max_border, exponent, slope, NO_BARRIERS
        )

    @lru_cache(scales)
    def barriers_at(scale: int) -> BarrierMap:
        barred = regions and regions.at_scale(scale, shape)
        return build_barrier_map(barred, shape_at_scale(shape, scale)) if barred else NO_BARRIERS

    known = free or build_field
    fields = kept(lambda scale, *key: copy_with(known(scale, *key), barrier_map=barriers_at(scale)))

    def field_at(scale: int, parameters: Parameters) -> ScaleField:
        own = parameters.channel, parameters.edges, parameters.gamma, parameters.smoothing
        return fields(scale, parameters.edge_floor, parameters.max_border, parameters.exponent_in(2), *own)

    return known, field_at
