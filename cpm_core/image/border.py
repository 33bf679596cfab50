"""The image border: the dark or bright rim that apertures, scanners and mounts leave around an image.

Its edge is often the strongest of the image and belongs to no object. It is recognized by its position: near a side of
the image and along it, straight, and over more than half of its length.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Array, Mask

_MIN_BORDER_STRENGTH = 0.1
"""Least strength of the edge of a border, as a fraction of the largest edge strength."""

_ALONG_SIDE_COSINE = 0.94
"""Cosine of the angle between the image gradient and the normal of the side, above which an edge follows it."""

_MAX_BORDER_DEVIATION = 0.02
"""Largest deviation of the edge of a border from a line, as a fraction of the shorter side."""

_MIN_VISIBLE_SHARE = 0.5
"""Fraction of a side along which its edge must be visible."""

_FLANK_WIDTH = 3.0
"""Width of an edge's flank, in sigma."""


def find_pixels_inside_border(
    slopes: Callable[[Window], Array], strength: Array, smoothing: float, widest: float
) -> Mask:
    r"""Pixels that do not belong to the image border, shape (\*shape): False on the border and on its edge.

    `slopes` gives the image gradient after a Gaussian of `smoothing` px in a window, `strength` is its magnitude. A
    border is searched up to the width `widest`, a fraction of the shortest side; 0 for none.
    """
    shape = strength.shape
    inside = np.ones(shape, bool)
    reach = int(widest * min(shape))
    if reach < 1:
        return inside
    faint = _MIN_BORDER_STRENGTH * strength.max()
    for axis, along in enumerate(shape):
        for reverse in (False, True):
            side = slice(max(along - reach - 2, 0), along) if reverse else slice(0, reach + 2)
            window = tuple(side if other == axis else slice(0, n) for other, n in enumerate(shape))
            parts = inside, slopes(window)[axis], strength[window]
            rim, slope, length = (np.moveaxis(values, axis, 0) for values in parts)
            if reverse:
                rim, slope, length = rim[::-1], slope[::-1], length[::-1]
            edge = np.where((length >= faint) & (np.abs(slope) >= _ALONG_SIDE_COSINE * length), slope, 0.0)
            depth = _find_border_edge(edge, int(_MAX_BORDER_DEVIATION * min(shape)) + 1)
            if depth >= 0:
                rim[: depth + 1 + int(_FLANK_WIDTH * max(smoothing, 1.0))] = False
    return inside


def _find_border_edge(edge: Array, stray: int) -> int:
    """Find the farthest line along a side that an edge of one sign follows over most of its length; -1 for none."""
    steepest = np.abs(edge[1:-1])
    ridge = (steepest >= np.abs(edge[:-2])) & (steepest > np.abs(edge[2:]))
    farthest = -1
    for sign in (-1.0, 1.0):
        on = (ridge & (edge[1:-1] * sign > 0.0)).view(np.uint8)
        near = scipy.ndimage.maximum_filter1d(on, 2 * stray + 1, axis=0, mode="nearest")
        lines = np.flatnonzero(near.reshape(len(near), -1).mean(axis=1) > _MIN_VISIBLE_SHARE)
        if len(lines):
            farthest = max(farthest, int(lines[-1]) + 1)
    return farthest


def dilate_by_distance(inside: Mask, reach: int) -> Mask:
    r"""Pixels whose centers are at most `reach` px from the center of a pixel of the mask `inside`, shape (\*shape)."""
    offsets = np.indices((2 * reach + 1,) * inside.ndim) - reach
    return scipy.ndimage.binary_dilation(inside, (offsets**2).sum(axis=0) <= reach**2)
