"""The area that a start covers: what a closed row of particles encloses, or a narrow band along an open one."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Mask

_LINK = 0.75
"""Multiple of the usual distance of neighbors up to which a row of particles is closed."""

_LEAST_LINK = 2.0
"""Least such distance [px]."""


def drawn_area(points: Array, shape: tuple[int, ...]) -> Mask:
    """Pixels of an image of this shape that a start covers.

    `points`, shape (N, 2), are its particles [px of the image]. Rows of particles are closed up to about the distance
    of neighbors, and what they enclose is filled.
    """
    on = np.zeros(shape, bool)
    place = np.clip(np.rint(points).astype(int), 0, np.array(shape) - 1)
    on[tuple(place.T)] = True
    if len(points) < 2:
        return on
    nearest, _ = scipy.spatial.cKDTree(points).query(points, k=[2])
    link = max(_LEAST_LINK, _LINK * float(np.median(nearest)))
    near = scipy.ndimage.distance_transform_edt(~on) <= link
    filled = scipy.ndimage.binary_fill_holes(near)
    return np.asarray(on | (scipy.ndimage.distance_transform_edt(filled) > link))


def radius_of(area: Mask) -> float:
    """Radius of the largest disk in each connected part of an area, the median of all parts [px]."""
    labels, count = scipy.ndimage.label(area, structure=np.ones((3, 3), bool))
    depth = scipy.ndimage.distance_transform_edt(area)
    return float(np.median(scipy.ndimage.maximum(depth, labels, np.arange(1, count + 1)))) if count else 0.0
