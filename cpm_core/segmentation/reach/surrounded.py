"""What a start has been drawn around: the thing inside it whose gray levels differ from those along it.

Gray levels near the drawn line tell what is around the thing, those farther in what it is. Each pixel goes to the side
whose histogram its surroundings fit better, then the histograms are made again, until nothing changes (two classes by
likelihood, as in GrabCut: Rother, Kolmogorov, Blake 2004, doi:10.1145/1015706.1015720, without its minimum cut). Then
the border is moved to the strongest edges near it (watershed from both sides).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import Labels, box_of
from cpm_core.numerics.types import Array, Index, Mask

_BAND = 0.3
"""Width of the band along the drawn line that is taken for the surroundings at first, in radii."""

_RIM = 0.04
"""Least distance of the thing from the drawn line, in radii."""

_SMOOTHING, _LEAST_SMOOTHING = 0.03, 0.7
"""Extent over which pixels are judged together, in radii, and its least [px]."""

_DENOISING, _LEAST_DENOISING, _MOST_DENOISING = 0.02, 0.5, 2.0
"""Smoothing of the gray levels in radii, and its limits [px]."""

_BINS, _BLUR, _FLOOR, _DECIMALS = 48, 1.5, 0.1, 6
"""Bins of the histograms, which hold as many pixels each; their smoothing [bins]; what counts as empty, in shares of
an even histogram; and decimals of logarithms, whose last bits differ between processors."""

_UNSURE = 0.08
"""Distance up to which the border is moved, in radii."""

_MOST_TURNS = 8
"""How often the histograms are made again at most."""

_KEPT = 0.3
"""Parts are kept whose area, weighted by depth, is at least this fraction of the largest one."""


def surrounded(values: Array, strength: Array, area: Mask) -> Mask:
    """What lies within the area of a start and differs from what is along its border.

    Parameters
    ----------
    values, strength : ndarray, shape (H, W)
        Image, and its edge strength.
    area : ndarray of bool, shape (H, W)
        What one connected piece of the start covers.

    Returns
    -------
    ndarray of bool, shape (H, W)
        The thing; empty when nothing differs.
    """
    found = np.zeros(area.shape, bool)
    if not area.any():
        return found
    box = box_of(area)
    depth = scipy.ndimage.distance_transform_edt(np.pad(area[box], 1))[1:-1, 1:-1]
    radius = float(depth.max())
    sigma = float(np.clip(_DENOISING * radius, _LEAST_DENOISING, _MOST_DENOISING))
    smooth = scipy.ndimage.gaussian_filter(values[box].astype(float), sigma, mode="nearest")
    bins = np.searchsorted(np.quantile(smooth[area[box]], np.arange(1, _BINS) / _BINS), smooth)
    thing = _parted(bins, depth / radius, max(_SMOOTHING * radius, _LEAST_SMOOTHING))
    found[box] = _on_edges(strength[box], area[box], thing, max(_UNSURE * radius, 1.0))
    return found


def _on_edges(strength: Array, area: Mask, thing: Mask, width: float) -> Mask:
    """A thing whose border has been moved to the strongest edges within some width [px]."""
    core = scipy.ndimage.distance_transform_edt(np.pad(thing, 1))[1:-1, 1:-1] > width
    if not core.any():
        return thing & area
    outside = (scipy.ndimage.distance_transform_edt(~thing) > width) | ~area
    return flooded(strength, core + 2 * outside.astype(np.int32)) == 1


def flooded(strength: Array, markers: Labels, basin: Mask | None = None) -> Labels:
    """Labels of the markers that reach each pixel of a basin, or of the image, over the lowest edges."""
    flood: Callable[..., Labels] = skimage.segmentation.watershed
    return np.asarray(flood(strength, markers, mask=basin), np.int32)


def _parted(bins: Index, depth: Array, extent: float) -> Mask:
    """The thing, shape (H, W), in a box of gray levels; `depth` [radii] is 0 outside the area."""
    thing = depth > _BAND
    area = depth > 0.0
    for _ in range(_MOST_TURNS):
        ratio = np.asarray(np.log(_histogram(bins[thing]) / _histogram(bins[area & ~thing])), np.float64)
        ratio = np.round(ratio, _DECIMALS)
        likely = (scipy.ndimage.gaussian_filter(ratio[bins], extent, mode="nearest") > 0.0) & (depth > _RIM)
        filled = np.asarray(scipy.ndimage.binary_fill_holes(likely))
        parts, count = scipy.ndimage.label(filled)
        weight = np.bincount(parts.ravel(), depth.ravel(), count + 1)
        weight[0] = 0.0
        after = (weight >= _KEPT * weight.max())[parts] & filled
        if not after.any() or (after == thing).all():
            return after
        thing = after
    return thing


def _histogram(bins: Index) -> Array:
    """Share of the pixels in each bin, smoothed, nowhere 0."""
    counts = np.bincount(bins, minlength=_BINS).astype(float)
    return scipy.ndimage.gaussian_filter1d(counts, _BLUR, 0, mode="nearest") / max(len(bins), 1) + _FLOOR / _BINS
