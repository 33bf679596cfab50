"""Gray levels and edges as the classical methods take them: from 0 to 1, whatever the range of the image."""

from __future__ import annotations

import scipy
import skimage

from cpm_core.field.edge_map import edge_map
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array


def unit_gray(image: Image) -> Array:
    """Gray levels from 0 to 1, shape (H, W)."""
    low, high = image.gray_range
    return (image.values - low) / max(high - low, 1e-300)


def unit_edges(image: Image, smoothing: float) -> Array:
    """The edge map of the charged particles, divided by its largest value, shape (H, W)."""
    strength = edge_map(unit_gray(image), smoothing)
    return strength / max(float(strength.max()), 1e-300)


def sobel_edges(image: Image, smoothing: float) -> Array:
    """Edges by the filter of Sobel, as scikit-image's ``active_contour`` takes them of a smoothed image."""
    smooth = scipy.ndimage.gaussian_filter(unit_gray(image), smoothing, mode="nearest")
    found: Array = skimage.filters.sobel(smooth)  # type: ignore[no-untyped-call]
    return found
