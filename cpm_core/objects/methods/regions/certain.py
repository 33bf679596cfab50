"""What a start says for certain of the pixels of an image: seeds of the object, and of the background."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Mask
from cpm_core.objects.methods.method import Start


def certain_pixels(start: Start, shape: tuple[int, ...], depth: float, margin: float) -> tuple[Mask, Mask]:
    """Pixels of the object and of the background, of this shape each; they may overlap at the border of the image.

    A start in the object is all object, and the border of the image, or what lies farther than `margin` from the
    start, background. A start around the object has in the object what is deeper in it than the fraction `depth` of
    the greatest depth, and what lies outside it is background.
    """
    inside = start.mask(shape)
    edt = scipy.ndimage.distance_transform_edt
    rim = np.ones(shape, dtype=bool)
    rim[(slice(1, -1),) * len(shape)] = False
    if start.around:
        deep = edt(np.pad(inside, 1))[(slice(1, -1),) * len(shape)]
        return inside & (deep >= depth * deep.max()), ~inside | rim
    return inside, edt(~inside) >= margin if margin > 0.0 else rim
