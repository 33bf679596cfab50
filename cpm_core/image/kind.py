"""The kind of an image, guessed from its gray levels, for settings that suit it.

A kind is only guessed where an image shows several signs of it; most images show none.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import scipy
import skimage

from cpm_core.numerics.types import Array

ImageKind = Literal["line art", "fluorescence", "angiogram", "ultrasound"]

_MAX_EXAMINED_SIDE = 512
"""Largest side of the image that is examined [px]; a larger one is reduced."""

_BLOCK_SIDE = 16
"""Side of the blocks whose brightness and structure are compared [px]."""

_MIN_BLOCKS = 6
"""Least number of blocks of an image whose kind is guessed."""

_EXTREME_SHARE = 0.06
"""Part of the range of gray levels at either end that counts as dark or bright."""


def guess_kind(values: Array) -> ImageKind | None:
    """Guess the kind of an image, shape (H, W); None where it shows the signs of none.

    Gray levels are taken from 0 to 1, without half a percent at either end.
    """
    if values.ndim != 2:
        return None
    step = math.ceil(max(values.shape) / _MAX_EXAMINED_SIDE)
    rows, cols = (side // step * step for side in values.shape)
    reduced = skimage.measure.block_reduce(values[:rows, :cols], step, np.mean)  # type: ignore[no-untyped-call]
    low, high = np.percentile(reduced, [0.5, 99.5])
    if not high > low:
        low, high = reduced.min(), reduced.max()
    blocks = min(reduced.shape) // _BLOCK_SIDE
    if blocks * blocks < _MIN_BLOCKS or not high > low:
        return None
    levels = np.clip((reduced - low) / (high - low), 0.0, 1.0)
    smooth = scipy.ndimage.gaussian_filter
    dark, bright = (levels < _EXTREME_SHARE).mean(), (levels > 1.0 - _EXTREME_SHARE).mean()
    between = 1.0 - dark - bright
    if between < 0.15 and min(dark, bright) > 2.0 * between:  # except for blurred edges, two gray levels alone
        return "line art"
    quarter, median, three_quarters = np.percentile(levels, [25.0, 50.0, 75.0]).tolist()
    mean, fine = _split_into_blocks(levels).mean(1), _split_into_blocks(levels - smooth(levels, 4.0)).std(1)
    structured = (fine > 0.05).mean()  # share of the blocks that hold more than noise
    kept = (mean > 0.03) & (mean < 0.97)
    # whether noise or structure grows with the signal, as speckle does
    growth, signal, rough = 0.0, np.log(mean[kept]), np.log(fine[kept] + 1e-3)
    if len(signal) >= _MIN_BLOCKS and signal.std() > 0.0 and rough.std() > 0.0:
        growth = np.corrcoef(signal, rough)[0, 1]
    band = smooth(levels, 2.0) - smooth(levels, 8.0)
    # skewness of structure of some pixels: positive for dark lines or spots, negative for bright ones
    thinness = -(band**3).mean() / max((band**2).mean() ** 1.5, 1e-300)
    if median < 0.2 and thinness < -1.2 and structured < 0.55 and growth > 0.6:  # bright objects on a dark background
        return "fluorescence"
    roughness = np.median(fine[kept] / mean[kept]) if kept.any() else 0.0
    even = structured < 0.25 and roughness < 0.08 and dark + bright < 0.08
    if even and thinness > 0.7 and three_quarters - quarter > 0.08:  # thin dark lines and almost nothing else
        return "angiogram"
    down, across = (np.abs(np.diff(levels, axis=axis)).mean() for axis in (0, 1))
    # speckle that lies across the beam, since ultrasound resolves depth better, and bright layers
    if across > 0.0 and down / across > 1.9 and growth > 0.25 and thinness < -0.4:
        return "ultrasound"
    return None


def _split_into_blocks(levels: Array) -> Array:
    """Split gray levels into blocks, shape (blocks, pixels)."""
    rows, cols = (side // _BLOCK_SIDE * _BLOCK_SIDE for side in levels.shape)
    blocks = skimage.util.view_as_blocks(levels[:rows, :cols], (_BLOCK_SIDE, _BLOCK_SIDE))  # type: ignore[no-untyped-call]
    return blocks.reshape(-1, _BLOCK_SIDE * _BLOCK_SIDE)
