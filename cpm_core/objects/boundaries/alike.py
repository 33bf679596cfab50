"""Likeness: pixels that differ from the surroundings of an object as the object does."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Mask

_CONTRAST = 0.4, 3.0
"""How far from the surroundings, towards the gray level of the object and beyond, gray levels are alike."""

_SMOOTHING = 1.5
"""Sigma of the smoothing of gray levels [px], at most a fifth of the radius."""

_AROUND = 0.5
"""Width of the surroundings, as a fraction of the radius."""


def alike(values: Array, mask: Mask, interest: Mask) -> Mask:
    """Pixels of interest whose gray level is like that of an object, shape (H, W), without small holes; with it."""
    radius = np.sqrt(np.count_nonzero(mask) / np.pi)
    away = scipy.ndimage.distance_transform_edt(~mask)
    ring = (away > 1.0) & (away <= max(2.0, _AROUND * radius) + 1.0)
    own, around = float(np.median(values[mask])), float(np.median(values[ring])) if ring.any() else 0.0
    smooth = scipy.ndimage.gaussian_filter(values, min(_SMOOTHING, 0.2 * radius))
    share = (smooth - around) / (own - around) if own != around else np.zeros_like(smooth)
    found = (share >= _CONTRAST[0]) & (share <= _CONTRAST[1]) & interest
    holes, _ = scipy.ndimage.label(~found)
    sizes = np.bincount(holes.ravel())
    return found | (sizes < 0.1 * radius**2)[holes] | mask
