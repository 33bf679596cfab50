"""The frame of an image: the dark or bright rim that apertures, scanners and mounts leave around what they show.

Its edge is often the strongest of the image and belongs to no object. It is told by where it lies: along a side, near
it, straight, and over more than half of its length.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.edge_map import magnitude

Array = NDArray[np.float64]

_FAINT = 0.1
"""Fraction of the largest edge strength that the edge of a frame must have."""

_ALONG = 0.94
"""Cosine of the angle between the image gradient and the normal of the side, within which an edge runs along it."""

_STRAIGHT = 0.02
"""How far the edge of a frame may stray from a line, as a fraction of the shorter side."""

_COVER = 0.5
"""Fraction of a side along which its edge must be seen."""

_FLANK = 3.0
"""Width of an edge's flank, in sigma."""


def inside_frame(grad: Array, smoothing: float, widest: float) -> NDArray[np.bool_]:
    r"""Pixels that no frame covers.

    Parameters
    ----------
    grad : ndarray, shape (D, \*shape)
        Image gradient.
    smoothing : float
        Gaussian that it was taken with [px].
    widest : float
        Width up to which a frame is looked for, as a fraction of the shortest side; 0 for none.

    Returns
    -------
    ndarray of bool, shape (\*shape)
        False on the frame, its edge included.
    """
    shape = grad.shape[1:]
    inside = np.ones(shape, bool)
    reach = int(widest * min(shape))
    if reach < 1:
        return inside
    strength = magnitude(grad)
    strong = strength >= _FAINT * strength.max()
    for axis in range(len(shape)):
        for turned in (False, True):
            edge = np.moveaxis(grad[axis] * strong * (np.abs(grad[axis]) >= _ALONG * strength), axis, 0)
            rim = np.moveaxis(inside, axis, 0)
            if turned:
                edge, rim = edge[::-1], rim[::-1]
            depth = _edge_of_frame(edge[: reach + 2], int(_STRAIGHT * min(shape)) + 1)
            if depth >= 0:
                rim[: depth + 1 + int(_FLANK * max(smoothing, 1.0))] = False
    return inside


def _edge_of_frame(edge: Array, stray: int) -> int:
    """Farthest line along a side that an edge of one sign follows over most of its length; -1 if there is none."""
    steepest = np.abs(edge[1:-1])
    crest = (steepest >= np.abs(edge[:-2])) & (steepest > np.abs(edge[2:]))
    farthest = -1
    for sign in (-1.0, 1.0):
        seen = crest & (edge[1:-1] * sign > 0.0)
        for line in range(len(seen)):
            near = seen[max(0, line - stray) : line + stray + 1].reshape(-1, *seen.shape[1:])
            if near.any(axis=0).mean() > _COVER:
                farthest = max(farthest, line + 1)
    return farthest
