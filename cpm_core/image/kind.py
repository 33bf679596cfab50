"""The kind of an image, guessed from its gray levels, for settings that suit it.

A kind is only guessed where several signs of it are seen; most images have none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
import scipy

from cpm_core.numerics.types import Array

Kind = Literal["line art", "fluorescence", "angiogram", "ultrasound"]

_SIDE = 512
"""Largest side of the image that is looked at [px]; a larger one is reduced."""

_BLOCK = 16
"""Side of the blocks whose brightness and structure are compared [px]."""

_LEAST_BLOCKS = 6
_ENDS = 0.06
"""Part of the range of gray levels at either end that counts as dark or bright."""


@dataclass(frozen=True, slots=True)
class Signs:
    """What tells the kinds of images apart; gray levels are from 0 to 1, without half a percent at either end.

    Attributes
    ----------
    dark, bright : float
        Shares of the pixels that are almost black, or almost white.
    median, spread : float
        Median gray level, and the distance between the quartiles.
    structured : float
        Share of the blocks that hold more than noise.
    roughness : float
        Median over the blocks of the standard deviation of fine structure relative to the mean.
    growth : float
        Correlation of the logarithms of fine structure and brightness over the blocks: positive for signals whose
        noise or structure grows with them, as speckle does.
    anisotropy : float
        Mean difference of neighbors along columns relative to that along rows; ultrasound resolves depth better.
    thinness : float
        Skewness of structure of some pixels: positive for dark lines or spots, negative for bright ones.
    """

    dark: float
    bright: float
    median: float
    spread: float
    structured: float
    roughness: float
    growth: float
    anisotropy: float
    thinness: float


def guessed_kind(values: Array) -> Kind | None:
    """The kind that an image, shape (H, W), looks like; None where it looks like none of them."""
    signs = signs_of(values)
    if signs is None:
        return None
    if _is_line_art(signs):
        return "line art"
    if _is_fluorescence(signs):
        return "fluorescence"
    if _is_angiogram(signs):
        return "angiogram"
    return "ultrasound" if _is_ultrasound(signs) else None


def signs_of(values: Array) -> Signs | None:
    """The signs of an image; None where it is too small or too even to have any."""
    reduced = _reduced(values)
    low, high = np.percentile(reduced, [0.5, 99.5])
    if not high > low:
        low, high = reduced.min(), reduced.max()
    blocks = min(reduced.shape) // _BLOCK
    if reduced.ndim != 2 or blocks * blocks < _LEAST_BLOCKS or not high > low:
        return None
    levels = np.clip((reduced - low) / (high - low), 0.0, 1.0)
    smooth = scipy.ndimage.gaussian_filter
    mean, fine = _blocks(levels).mean(1), _blocks(levels - smooth(levels, 4.0)).std(1)
    kept = (mean > 0.03) & (mean < 0.97)
    band = smooth(levels, 2.0) - smooth(levels, 8.0)
    down, across = (float(np.abs(np.diff(levels, axis=axis)).mean()) for axis in (0, 1))
    quarter, middle, three_quarters = np.percentile(levels, [25.0, 50.0, 75.0]).tolist()
    return Signs(
        dark=float((levels < _ENDS).mean()),
        bright=float((levels > 1.0 - _ENDS).mean()),
        median=middle,
        spread=three_quarters - quarter,
        structured=float((fine > 0.05).mean()),
        roughness=float(np.median(fine[kept] / mean[kept])) if kept.any() else 0.0,
        growth=_correlation(np.log(mean[kept]), np.log(fine[kept] + 1e-3)),
        anisotropy=down / across if across > 0.0 else math.inf,
        thinness=-float((band**3).mean() / max((band**2).mean() ** 1.5, 1e-300)),
    )


def _is_line_art(signs: Signs) -> bool:
    """Two gray levels, and few others between them than at blurred edges."""
    between = 1.0 - signs.dark - signs.bright
    return between < 0.15 and min(signs.dark, signs.bright) > 2.0 * between


def _is_fluorescence(signs: Signs) -> bool:
    """Bright objects apart from each other on a dark and even background."""
    return signs.median < 0.2 and signs.thinness < -1.2 and signs.structured < 0.55 and signs.growth > 0.6


def _is_angiogram(signs: Signs) -> bool:
    """Thin dark lines on a background without ends of the gray levels and almost without other structure."""
    even = signs.structured < 0.25 and signs.roughness < 0.08 and signs.dark + signs.bright < 0.08
    return even and signs.thinness > 0.7 and signs.spread > 0.08


def _is_ultrasound(signs: Signs) -> bool:
    """Speckle that lies across the beam and grows with the echo, and bright layers."""
    return signs.anisotropy > 1.9 and math.isfinite(signs.anisotropy) and signs.growth > 0.25 and signs.thinness < -0.4


def _reduced(values: Array) -> Array:
    """The image with sides of at most `_SIDE`, as means over squares."""
    step = math.ceil(max(values.shape) / _SIDE)
    if step == 1:
        return np.asarray(values, np.float64)
    rows, cols = (side // step for side in values.shape)
    squares = values[: rows * step, : cols * step].reshape(rows, step, cols, step)
    return np.asarray(squares.mean(axis=(1, 3)))


def _blocks(levels: Array) -> Array:
    """The pixels of each block, shape (blocks, pixels)."""
    rows, cols = (side // _BLOCK for side in levels.shape)
    cut = levels[: rows * _BLOCK, : cols * _BLOCK].reshape(rows, _BLOCK, cols, _BLOCK)
    return cut.swapaxes(1, 2).reshape(rows * cols, _BLOCK * _BLOCK)


def _correlation(first: Array, second: Array) -> float:
    if len(first) < _LEAST_BLOCKS or first.std() == 0.0 or second.std() == 0.0:
        return 0.0
    return float(np.corrcoef(first, second)[0, 1])
