"""A second image, such as a label map or a PET, in the grid of the image that it lies over."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cpm_app.model.display.display_image import DisplayImage
from cpm_core import Image
from cpm_core.image.resampling import find_grid_mapping, resample_image
from cpm_core.numerics.types import Pixels, record

LABEL_SHADES = 255
"""Number of shades of labels: more labels share them."""

_PLANES_AT_ONCE = 8
"""Planes, or blocks of 16 rows of an image, that are resampled at once."""


@record
class SecondImage:
    """Shades of a second image, in the shape of the first.

    Attributes
    ----------
    name : str
        Name of its file.
    is_labels : bool
        Whether shades stand for labels; otherwise for gray levels from the darkest, 1, to the brightest, 255.
    shades : ndarray of uint8, shape (H, W) or (P, R, C)
        Shades; 0 outside, and in the background of labels.
    """

    name: str
    is_labels: bool
    shades: Pixels

    def display(self, shades: Pixels) -> DisplayImage:
        """Return the display image of its shades, or of a slice of them."""
        return DisplayImage.from_labels(shades) if self.is_labels else DisplayImage.from_shades(shades)


def build_second_image(image: Image, target: Image, is_labels: bool, advance: Callable[[float], None]) -> SecondImage:
    """Build the second image from an image, in the grid of a target; `advance` gets the finished fraction."""
    mapping = find_grid_mapping(image, target)
    shades = np.zeros(target.shape, np.uint8)
    low, high = image.shown_range
    step = _PLANES_AT_ONCE if target.ndim == 3 else 16 * _PLANES_AT_ONCE
    for first in range(0, len(shades), step):
        advance(first / len(shades))
        end = min(first + step, len(shades))
        levels = resample_image(image, mapping, target, first, end, nearest=is_labels)
        seen = np.isfinite(levels)
        levels[~seen] = low
        if is_labels:
            seen &= levels > 0.0
            found = (levels - 1.0) % LABEL_SHADES
        else:
            found = 254.0 * np.clip((levels - low) / max(high - low, 1e-30), 0.0, 1.0)
        shades[first:end] = np.where(seen, 1.0 + np.rint(found), 0.0)
    return SecondImage(image.source, is_labels, shades)
