"""Pixels that contrast with the surroundings of an object as the object does."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.grids import bounding_window, expand_window
from cpm_core.numerics.types import Array, Mask, Single

_MIN_CONTRAST_RATIO = 0.4
"""Least contrast of a similar gray level with the surroundings, in contrasts of the object."""

_MAX_CONTRAST_RATIO = 3.0
"""Largest such contrast."""

_MAX_GRAY_SMOOTHING = 1.5
"""Sigma of the smoothing of gray levels [px]; at most a fifth of the radius is used."""

_SURROUNDINGS_RATIO = 0.5
"""Width of the surroundings, as a fraction of the radius."""


def measure_radius(mask: Mask, sides: Array) -> float:
    """Measure the radius of the disk or the ball that is as large as a mask, with pixels of these sides."""
    size = np.count_nonzero(mask) * float(np.prod(sides))
    return float(np.sqrt(size / np.pi) if mask.ndim == 2 else np.cbrt(0.75 * size / np.pi))


def find_similar_pixels(values: Array | Single, mask: Mask, interest: Mask, sides: Array | None = None) -> Mask:
    """Find the pixels of interest whose gray level is similar to that of an object, all of the shape of `values`.

    Returns them and the object, without small holes. `sides` are those of a voxel, the smallest being 1.
    """
    sides = np.ones(mask.ndim) if sides is None else sides
    radius = measure_radius(mask, sides)
    width = max(2.0, _SURROUNDINGS_RATIO * radius) + 1.0
    window = expand_window(bounding_window(mask), int(width) + 1, mask.shape)
    away = scipy.ndimage.distance_transform_edt(~mask[window], sampling=sides)
    ring = values[window][(away > 1.0) & (away <= width)]
    own, around = float(np.median(values[mask])), float(np.median(ring)) if len(ring) else 0.0
    smooth = scipy.ndimage.gaussian_filter(values, min(_MAX_GRAY_SMOOTHING, 0.2 * radius) / sides)
    share = (smooth - around) / (own - around) if own != around else np.zeros_like(smooth)
    found = (share >= _MIN_CONTRAST_RATIO) & (share <= _MAX_CONTRAST_RATIO) & interest
    holes, _ = scipy.ndimage.label(~found)
    sizes = np.bincount(holes.ravel())
    return found | (sizes < 0.1 * radius**2)[holes] | mask
