"""The tree of vessels that points or a scribble lie in: connected lines that are long and thin."""

from __future__ import annotations

import numpy as np
import scipy
import skimage

from cpm_core.image.vesselness import filter_lines
from cpm_core.numerics.grids import true_bounds
from cpm_core.numerics.types import Array, Index, Mask

_FIRST_REACH = 40
"""Distance from the points at which something long is looked for first [px]."""

_TREE_REACH = 500
"""Distance from the points up to which a tree is followed [px]."""

_MIN_LINE_LENGTH = 6.0
"""Least length of what is near the points, in its mean widths."""

_MIN_TREE_LENGTH = 60.0
"""Least length of a tree, in its mean widths: outlines of cells, hair and furrows are shorter."""

_MAX_TREE_FILL = 0.05
"""Largest area of a tree, as a fraction of the squared diagonal of its box: cells and furrows fill theirs."""

_MIN_POINT_SHARE = 0.7
"""Least share of the points that lie in the tree."""


def find_vessel_tree(values: Array, pixels: Index) -> Mask | None:
    """Find the tree of vessels of an image, shape (H, W), that pixels, shape (N, 2), lie in; None without one."""
    if not len(pixels):
        return None
    for reach, slender, thin in (
        (_FIRST_REACH, _MIN_LINE_LENGTH, 1.0),
        (_TREE_REACH, _MIN_TREE_LENGTH, _MAX_TREE_FILL),
    ):
        low = np.maximum(pixels.min(axis=0) - reach, 0)
        high = pixels.max(axis=0) + reach + 1
        box = slice(low[0], high[0]), slice(low[1], high[1])
        tree = _find_line_around(values[box], pixels - low, slender, thin)
        if tree is None:
            return None
    whole = np.zeros(values.shape, bool)
    whole[box] = tree
    return whole


def _find_line_around(values: Array, pixels: Index, slender: float, thin: float) -> Mask | None:
    """Find the connected lines that hold pixels, if long in mean widths and filling little of their box."""
    dark, bright = filter_lines(values)
    for kind, other in ((dark, bright), (bright, dark)):
        parts, count = scipy.ndimage.label(kind.find_pixels_above_chance(other), np.ones((3, 3)))
        held = np.bincount(parts[tuple(pixels.T)], minlength=count + 1)
        held[0] = 0
        if held.max() < _MIN_POINT_SHARE * len(pixels):
            continue
        part = parts == held.argmax()
        middle = skimage.morphology.skeletonize(part)  # type: ignore[no-untyped-call]
        area, length = np.count_nonzero(part), np.count_nonzero(middle)
        slope = scipy.ndimage.gaussian_gradient_magnitude(values, 1.0)[middle]
        across = float(np.square(np.diff(true_bounds(part), axis=0)).sum())
        # the image is level along the middle of a line, but steepest at the rim of a disk, which bends as well
        if (
            np.median(slope) < np.median(kind.contrast[middle])
            and length**2 >= slender * area
            and area <= thin * across
        ):
            return np.asarray(part)
    return None
