"""Pixels that contrast with the surroundings of an object as the object does."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Mask

_MIN_CONTRAST_RATIO = 0.4
"""Least contrast of a similar gray level with the surroundings, in contrasts of the object."""

_MAX_CONTRAST_RATIO = 3.0
"""Largest such contrast."""

_MAX_GRAY_SMOOTHING = 1.5
"""Sigma of the smoothing of gray levels [px]; at most a fifth of the radius is used."""

_SURROUNDINGS_RATIO = 0.5
"""Width of the surroundings, as a fraction of the radius."""


def find_similar_pixels(values: Array, mask: Mask, interest: Mask) -> Mask:
    """Find the pixels of interest whose gray level is similar to that of an object, all of shape (H, W).

    Returns them and the object, shape (H, W), without small holes.
    """
    radius = np.sqrt(np.count_nonzero(mask) / np.pi)
    away = scipy.ndimage.distance_transform_edt(~mask)
    ring = (away > 1.0) & (away <= max(2.0, _SURROUNDINGS_RATIO * radius) + 1.0)
    own, around = float(np.median(values[mask])), float(np.median(values[ring])) if ring.any() else 0.0
    smooth = scipy.ndimage.gaussian_filter(values, min(_MAX_GRAY_SMOOTHING, 0.2 * radius))
    share = (smooth - around) / (own - around) if own != around else np.zeros_like(smooth)
    found = (share >= _MIN_CONTRAST_RATIO) & (share <= _MAX_CONTRAST_RATIO) & interest
    holes, _ = scipy.ndimage.label(~found)
    sizes = np.bincount(holes.ravel())
    return found | (sizes < 0.1 * radius**2)[holes] | mask
