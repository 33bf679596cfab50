"""The pyramid of images, and the mapping between its scales (section 4.2).

Scale 0 is the image itself, scale s has half the pixels of scale s - 1 along each axis. The grids of all scales share
their center, so that a mirrored or turned image has a mirrored or turned pyramid.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import scipy

from cpm_core.numerics.grids import run_in_bands, smooth_rows
from cpm_core.numerics.types import Array, Arrays, Extent

MIN_COARSEST_SIDE = 8
"""Least side of the coarsest scale [px]."""

_REDUCTION_SMOOTHING = 1.0
"""Gaussian before every second pixel is taken [px]; about that of the standard 5-tap kernel."""


def max_scales(shape: Extent) -> int:
    """Return the largest number of scales of an image of this shape."""
    side, scales = min(shape), 1
    while (side + 1) // 2 >= MIN_COARSEST_SIDE:
        side, scales = (side + 1) // 2, scales + 1
    return scales


def shape_at_scale(shape: Extent, scale: int) -> Extent:
    """Return the shape of an image of shape `shape` at a scale."""
    for _ in range(scale):
        shape = tuple((n + 1) // 2 for n in shape)
    return shape


def check_scales(scales: int, shape: Extent) -> None:
    """Raise `ValueError` when the coarsest scale would be smaller than 8 pixels."""
    most = max_scales(shape)
    if scales > most:
        size = " x ".join(map(str, shape))
        raise ValueError(f"scales is {scales} but must be from 1 to {most} for an image of {size} pixels.")


def build_pyramid(values: Array, scales: int) -> Arrays:
    r"""Gaussian pyramid of an image, shape (\*shape): it and its reductions, from fine to coarse, `scales` in all."""
    images = [np.ascontiguousarray(values)]
    for scale in range(1, scales):
        fine, coarse = images[-1], np.empty(shape_at_scale(values.shape, scale))
        if values.ndim == 2:
            run_in_bands(partial(_reduce_rows, fine, coarse), len(coarse))
        else:
            coarse[...] = _take_every_second(
                scipy.ndimage.gaussian_filter(fine, _REDUCTION_SMOOTHING, mode="nearest"), fine.shape
            )
        images.append(coarse)
    return tuple(images)


def _reduce_rows(fine: Array, coarse: Array, first: int, end: int) -> None:
    """Write some rows of the next scale of an image."""
    smooth = smooth_rows(fine, _REDUCTION_SMOOTHING, 2 * first, 2 * end)
    coarse[first:end] = _take_every_second(smooth, fine.shape)


def _take_every_second(fine: Array, shape: Extent) -> Array:
    """Take every second pixel of a part of an image of this shape, or, halfway between pixels, the mean of two."""
    for axis in range(fine.ndim):
        across = (slice(None),) * axis
        even, odd = fine[(*across, slice(0, None, 2))], fine[(*across, slice(1, None, 2))]
        fine = even if shape[axis] % 2 else 0.5 * (even + odd)  # the coarse grid has the same center
    return fine


def _image_center(shape: Extent) -> Array:
    return 0.5 * (np.array(shape, float) - 1.0)


def to_image(positions: Array, scale: int, shape: Extent) -> Array:
    """Convert positions (N, D) of a scale to px of the image of shape `shape`."""
    if scale == 0:
        return positions
    return (positions - _image_center(shape_at_scale(shape, scale))) * 2.0**scale + _image_center(shape)


def to_scale(positions: Array, scale: int, shape: Extent) -> Array:
    """Convert positions (N, D) of the image of shape `shape` to px of a scale."""
    if scale == 0:
        return positions
    return (positions - _image_center(shape)) * 0.5**scale + _image_center(shape_at_scale(shape, scale))
