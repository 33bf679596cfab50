"""Settings for large images, in which particles have far to go and noise stops them on their way."""

from __future__ import annotations

import math

import numpy as np

from cpm_core.field.edge_map import automatic_smoothing, smoothed_gradient, vector_magnitudes
from cpm_core.field.scale_field import LARGE_IMAGE_PIXELS
from cpm_core.image.gray_levels import limit_specks
from cpm_core.image.pyramid import max_scales
from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Array, Extent, frozen

_COARSEST_SCALE_SIDE = 512
"""Longest side of the coarsest scale at most [px]: a front crosses it in some hundred steps."""

_SAMPLE_SIDE = 256
"""Side of the part of an image whose noise and edges are measured: an edge across it is more than one pixel in a
hundred, which `automatic_smoothing` takes for the strong ones [px]."""


@frozen
class LargeImageSettings:
    """Number of scales and sigma of the Gaussian [px] that suit a large image."""

    scales: int
    smoothing: float


def large_image_settings(values: Array) -> LargeImageSettings | None:
    """Return settings that suit an image, shape (H, W); None for one that is not large.

    There are as many scales as bring the longest side of the coarsest one down to 512 px or less. The smoothing is the
    least that raises edges above the background (`automatic_smoothing`), around the strongest edge of the image.
    """
    if values.size <= LARGE_IMAGE_PIXELS:
        return None
    side = max(max(values.shape) // _COARSEST_SCALE_SIDE, 1)
    rows, cols = (n // side for n in values.shape)
    blocks = values[: rows * side, : cols * side].reshape(rows, side, cols, side).mean(axis=(1, 3))
    part = values[strongest_edge_window(limit_specks(blocks), side, values.shape)]
    return LargeImageSettings(scales_for(values.shape), automatic_smoothing(part))


def scales_for(shape: Extent) -> int:
    """Return the number of scales of a large image of this shape, no more than it has room for."""
    wanted = 1 + max(math.ceil(math.log2(max(shape) / _COARSEST_SCALE_SIDE)), 0)
    return min(wanted, max_scales(shape))


def strongest_edge_window(blocks: Array, side: int, shape: Extent) -> Window:
    """Return the window around the strongest edge of an image of this shape, from means of blocks of `side` px."""
    strength = vector_magnitudes(smoothed_gradient(blocks, 1.0))
    middle = side * np.array(np.unravel_index(int(np.argmax(strength)), strength.shape))
    starts = (
        int(min(max(at - _SAMPLE_SIDE // 2, 0), max(n - _SAMPLE_SIDE, 0))) for at, n in zip(middle, shape, strict=True)
    )
    return tuple(slice(start, start + _SAMPLE_SIDE) for start in starts)
