"""The tree of vessels that a place or a stroke lies in: what is fine, long, and hangs together."""

from __future__ import annotations

import numpy as np
import scipy
import skimage

from cpm_core.image.vesselness import lines
from cpm_core.numerics.grids import ends
from cpm_core.numerics.types import Array, Index, Mask

_NEAR, _REACH = 40, 500
"""Distance from the places at which something long is looked for first, and up to which a tree is followed [px]."""

_LONG, _SLENDER, _THIN = 6.0, 60.0, 0.05
"""Least length of what is near the places and of a tree, in its mean widths; and largest area of a tree, as a fraction
of the squared diagonal of the box around it: outlines of cells, hair and furrows are shorter, or fill their box."""

_ON = 0.7
"""Share of the places that lie in the tree."""


def vessel_tree(values: Array, pixels: Index) -> Mask | None:
    """The tree of vessels of an image, shape (H, W), that pixels, shape (N, 2), lie in; None where they lie in none."""
    if not len(pixels):
        return None
    for reach, slender, thin in ((_NEAR, _LONG, 1.0), (_REACH, _SLENDER, _THIN)):
        low = np.maximum(pixels.min(axis=0) - reach, 0)
        high = pixels.max(axis=0) + reach + 1
        box = slice(low[0], high[0]), slice(low[1], high[1])
        tree = _line_around(values[box], pixels - low, slender, thin)
        if tree is None:
            return None
    whole = np.zeros(values.shape, bool)
    whole[box] = tree
    return whole


def _line_around(values: Array, pixels: Index, slender: float, thin: float) -> Mask | None:
    """The lines that hang together and hold pixels, if they are so long in mean widths and fill so little of a box."""
    dark, bright = lines(values)
    for kind, other in ((dark, bright), (bright, dark)):
        parts, count = scipy.ndimage.label(kind.above_chance(other), np.ones((3, 3)))
        held = np.bincount(parts[tuple(pixels.T)], minlength=count + 1)
        held[0] = 0
        if held.max() < _ON * len(pixels):
            continue
        part = parts == held.argmax()
        middle = skimage.morphology.skeletonize(part)  # type: ignore[no-untyped-call]
        area, length = np.count_nonzero(part), np.count_nonzero(middle)
        slope = scipy.ndimage.gaussian_gradient_magnitude(values, 1.0)[middle]
        across = float(np.square(np.diff(ends(part), axis=0)).sum())
        # in the middle of a line the image is level; the rim of a disk, which bends, is steepest there
        if (
            np.median(slope) < np.median(kind.contrast[middle])
            and length**2 >= slender * area
            and area <= thin * across
        ):
            return np.asarray(part)
    return None
