"""What candidates are judged by: gray levels and ranks of edge strength, at several resolutions."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Mask, Pixels, Single

LEVELS = 512
"""Gray levels that a flood distinguishes."""

BINS = 32
"""Bins of the histograms of gray levels."""

_SIGMA = 1.0
"""Smoothing of the gray levels [px]."""

_STRIDES = (1, 2, 4, 8, 16)


class Resolution(NamedTuple):
    """An image reduced by a whole factor.

    Attributes
    ----------
    rank : ndarray of float32, shape (h, w)
        Share of pixels of a weaker edge, 0 to 1; of each block of pixels the strongest.
    gray : ndarray of float32, shape (h, w)
        Mean gray level of each block.
    bin : ndarray of uint8, shape (h, w)
        Bin of this gray level.
    strength : ndarray of float32, shape (h, w)
        Edge strength; of each block of pixels the strongest.
    """

    rank: Single
    gray: Single
    bin: Pixels
    strength: Single


class Appearance(NamedTuple):
    """An image as candidates see it.

    Attributes
    ----------
    level : ndarray of int16, shape (H, W)
        Gray level as a whole number from 0 to `LEVELS` - 1.
    deviation : float
        Standard deviation of the gray levels.
    resolutions : tuple of Resolution
        Reduced by 1, 2, 4, 8 and 16.
    """

    level: np.ndarray[tuple[int, ...], np.dtype[np.int16]]
    deviation: float
    resolutions: tuple[Resolution, ...]


def appearance(values: Array, strength: Array) -> Appearance:
    """Prepare an image and its edge map, both of shape (H, W)."""
    gray = scipy.ndimage.gaussian_filter(values, _SIGMA)
    low, high = np.percentile(gray, (0.2, 99.8))
    span = max(float(high - low), 1e-300)

    def share(levels: Array) -> Array:
        return np.asarray(np.clip((levels - low) / span, 0.0, 1.0))

    found = []
    for stride in _STRIDES:
        means, strongest = _blocks(gray, stride, np.mean), _blocks(strength, stride, np.max)
        ranks = _ranks(strongest) / strongest.size
        bins = (share(means) * (BINS - 0.01)).astype(np.uint8)
        found.append(Resolution(ranks.astype(np.float32), means.astype(np.float32), bins, strongest.astype(np.float32)))
    level = (share(gray) * (LEVELS - 1)).astype(np.int16)
    return Appearance(level, max(float(gray.std()), 1e-300), tuple(found))


def _ranks(values: Array) -> Array:
    """Rank of each value, from 1; equal ones share the mean of theirs. Loading `scipy.stats` takes half a second."""
    _, places, counts = np.unique(values, return_inverse=True, return_counts=True)
    return np.asarray((np.cumsum(counts) - (counts - 1) / 2)[places].reshape(values.shape))


def log_ratio(bins: Pixels, chosen: Mask) -> Array:
    """Logarithm of how much likelier each gray level is inside a selection than outside, shape (`BINS`,)."""
    logs = []
    for part in (chosen, ~chosen):
        counts = scipy.ndimage.gaussian_filter1d(np.bincount(bins[part], minlength=BINS).astype(float), 1.0)
        counts += 0.01 * part.sum() / BINS + 0.1
        logs.append(np.log(counts / counts.sum()))
    return np.asarray(logs[0] - logs[1])


def _blocks(values: Array, stride: int, reduce: Callable[..., Array]) -> Array:
    """Blocks of `stride` by `stride` pixels, each reduced to one value; the last ones repeat the border."""
    if stride == 1:
        return values
    rows, cols = (-(-size // stride) for size in values.shape)
    whole = np.pad(values, ((0, rows * stride - values.shape[0]), (0, cols * stride - values.shape[1])), mode="edge")
    return reduce(whole.reshape(rows, stride, cols, stride), axis=(1, 3))
