"""Long and thin objects that points or a scribble lie in: trees of vessels, cracks, roots, fibers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy
import skimage

from cpm_core.image.vesselness import filter_lines
from cpm_core.numerics.grids import label_parts, true_bounds
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

_MIN_RELATIVE_CONTRAST = 0.4
"""Least contrast of its pixels, in that of the nearest one in its middle."""

_MIN_POINT_SHARE = 0.7
"""Least share of the points that lie in the tree."""


class ThinObject(NamedTuple):
    """Connected lines.

    Attributes
    ----------
    mask : ndarray of bool, shape (H, W)
        Their pixels.
    is_tree : bool
        Whether they are so long and thin that they can only be a tree of vessels, or the like.
    """

    mask: Mask
    is_tree: bool


def find_thin_object(values: Array, pixels: Index) -> ThinObject | None:
    """Find the connected lines of an image, shape (H, W), that pixels, shape (N, 2), lie in; None without any."""
    if not len(pixels):
        return None
    if _find_lines_around(values, pixels, _FIRST_REACH) is None:
        return None
    return _find_lines_around(values, pixels, _TREE_REACH)


def _find_lines_around(values: Array, pixels: Index, reach: int) -> ThinObject | None:
    """Find the connected lines that hold pixels, up to a distance from these [px], if long in mean widths."""
    low = np.maximum(pixels.min(axis=0) - reach, 0)
    high = pixels.max(axis=0) + reach + 1
    box = slice(low[0], high[0]), slice(low[1], high[1])
    near, inside = values[box], tuple((pixels - low).T)
    dark, bright = filter_lines(near)
    for kind, other in ((dark, bright), (bright, dark)):
        parts, count = label_parts(kind.find_pixels_above_chance(other))
        held = np.bincount(parts[inside], minlength=count + 1)
        held[0] = 0
        if held.max() < _MIN_POINT_SHARE * len(pixels):
            continue
        part = parts == held.argmax()
        middle = skimage.morphology.skeletonize(part)  # type: ignore[no-untyped-call]
        area, length = np.count_nonzero(part), np.count_nonzero(middle)
        slope = scipy.ndimage.gaussian_gradient_magnitude(near, 1.0)[middle]
        # the image is level along the middle of a line, but steepest at the rim of a disk, which bends as well
        if np.median(slope) < np.median(kind.contrast[middle]) and length**2 >= _MIN_LINE_LENGTH * area:
            across = float(np.square(np.diff(true_bounds(part), axis=0)).sum())
            _, nearest = scipy.ndimage.distance_transform_edt(~middle, return_indices=True)
            clear = part & (middle | (kind.contrast >= _MIN_RELATIVE_CONTRAST * kind.contrast[tuple(nearest)]))
            whole = np.zeros(values.shape, bool)
            whole[box] = clear
            return ThinObject(whole, bool(length**2 >= _MIN_TREE_LENGTH * area and area <= _MAX_TREE_FILL * across))
    return None
