"""The object that a start has been drawn around: its gray levels differ from those along the start.

Gray levels near the drawn line are those of the surroundings, those farther in are those of the object. Each pixel goes
to the side whose histogram its surroundings fit better, then the histograms are computed again, until nothing changes
(two classes by likelihood, as in GrabCut: Rother, Kolmogorov, Blake 2004, doi:10.1145/1015706.1015720, without its
minimum cut). Then the border is moved to the strongest edges near it (watershed from both sides).
"""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.grids import bounding_window, flood_from_markers, measure_depth
from cpm_core.numerics.types import Array, Index, Mask

_SURROUNDINGS_WIDTH = 0.3
"""Width of the band along the drawn line that is taken for the surroundings at first, in radii."""

_MIN_LINE_GAP = 0.04
"""Least distance of the object from the drawn line, in radii."""

_JUDGED_EXTENT = 0.03
"""Extent over which pixels are judged together, in radii."""

_MIN_JUDGED_EXTENT = 0.7
"""Least such extent [px]."""

_DENOISING_SIGMA = 0.02
"""Smoothing of the gray levels, in radii."""

_MIN_DENOISING_SIGMA = 0.5
"""Least smoothing of the gray levels [px]."""

_MAX_DENOISING_SIGMA = 2.0
"""Greatest smoothing of the gray levels [px]."""

_GRAY_BINS = 48
"""Number of bins of the histograms, which hold as many pixels each."""

_HISTOGRAM_BLUR = 1.5
"""Smoothing of the histograms [bins]."""

_EMPTY_SHARE = 0.1
"""Share of an even histogram that an empty bin counts as."""

_RATIO_DECIMALS = 6
"""Decimals of logarithms, whose last bits differ between processors."""

_SNAPPING_WIDTH = 0.08
"""Distance up to which the border is moved, in radii."""

_MAX_HISTOGRAM_ROUNDS = 8
"""Largest number of times that the histograms are computed."""

_MIN_KEPT_WEIGHT = 0.3
"""Least area, weighted by depth, of parts that are kept, as a fraction of the largest one."""


def find_surrounded_object(values: Array, strength: Array, area: Mask) -> Mask:
    """Find the object within the area of a start that differs from the surroundings along its border.

    Parameters
    ----------
    values, strength : ndarray, shape (H, W)
        Image, and its edge strength.
    area : ndarray of bool, shape (H, W)
        Area that one connected piece of the start covers.

    Returns
    -------
    ndarray of bool, shape (H, W)
        The object; empty when nothing differs.
    """
    found = np.zeros(area.shape, bool)
    if not area.any():
        return found
    box = bounding_window(area)
    depth = measure_depth(area[box])
    radius = float(depth.max())
    sigma = float(np.clip(_DENOISING_SIGMA * radius, _MIN_DENOISING_SIGMA, _MAX_DENOISING_SIGMA))
    smooth = scipy.ndimage.gaussian_filter(values[box].astype(float), sigma, mode="nearest")
    bins = np.searchsorted(np.quantile(smooth[area[box]], np.arange(1, _GRAY_BINS) / _GRAY_BINS), smooth)
    inner = _separate_object(bins, depth / radius, max(_JUDGED_EXTENT * radius, _MIN_JUDGED_EXTENT))
    found[box] = _snap_to_edges(strength[box], area[box], inner, max(_SNAPPING_WIDTH * radius, 1.0))
    return found


def _snap_to_edges(strength: Array, area: Mask, inner: Mask, width: float) -> Mask:
    """Move the border of an object to the strongest edges within some width [px]."""
    core = measure_depth(inner) > width
    if not core.any():
        return inner & area
    outside = (scipy.ndimage.distance_transform_edt(~inner) > width) | ~area
    return flood_from_markers(strength, core + 2 * outside.astype(np.int32)) == 1


def _separate_object(bins: Index, depth: Array, extent: float) -> Mask:
    """Separate the object, shape (H, W), in a box of gray levels; `depth` [radii] is 0 outside the area."""
    inner = depth > _SURROUNDINGS_WIDTH
    area = depth > 0.0
    for _ in range(_MAX_HISTOGRAM_ROUNDS):
        ratio = np.asarray(
            np.log(_smoothed_histogram(bins[inner]) / _smoothed_histogram(bins[area & ~inner])), np.float64
        )
        ratio = np.round(ratio, _RATIO_DECIMALS)
        likely = (scipy.ndimage.gaussian_filter(ratio[bins], extent, mode="nearest") > 0.0) & (depth > _MIN_LINE_GAP)
        filled = np.asarray(scipy.ndimage.binary_fill_holes(likely))
        parts, count = scipy.ndimage.label(filled)
        weight = np.bincount(parts.ravel(), depth.ravel(), count + 1)
        weight[0] = 0.0
        after = (weight >= _MIN_KEPT_WEIGHT * weight.max())[parts] & filled
        if not after.any() or (after == inner).all():
            return after
        inner = after
    return inner


def _smoothed_histogram(bins: Index) -> Array:
    """Return the share of the pixels in each bin, smoothed, nowhere 0."""
    counts = np.bincount(bins, minlength=_GRAY_BINS).astype(float)
    return (
        scipy.ndimage.gaussian_filter1d(counts, _HISTOGRAM_BLUR, 0, mode="nearest") / max(len(bins), 1)
        + _EMPTY_SHARE / _GRAY_BINS
    )
