"""Sides: which parts of a medial axis lie in objects, and which in the background."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from cpm_core.medial_axis.axis import Axis
from cpm_core.medial_axis.boundary import Boundary
from cpm_core.medial_axis.pruning import parts
from cpm_core.medial_axis.smoothed_step import step_height

Array = NDArray[np.float64]

_MIDDLE = 0.5
"""Fraction of the largest radius of a part from which on a vertex is far enough from edges to tell its grey level."""

_DIFFERENT = 0.25
"""Part of the contrast of an edge by which what lies behind it must differ from the background to be an object."""

_LEAST_SMOOTHING = 1.0
"""Smoothing of the grey levels that are compared [px]."""


def within_objects(axis: Axis, boundary: Boundary, values: Array, smoothing: float) -> NDArray[np.bool_]:
    """Tell which edges of an axis lie in objects.

    The background has the grey level of the image's border (the median of its outermost pixels). A connected part of
    the axis lies in an object if its grey level differs from that by more than a quarter of the contrast of the edges
    around it, be it brighter or darker; so the hole of a ring is background again.

    Parameters
    ----------
    axis : Axis
        Medial axis of all that the boundary parts.
    boundary : Boundary
        The edges.
    values : ndarray, shape (H, W)
        Image.
    smoothing : float
        Sigma with which the strength of the edges was taken [px].

    Returns
    -------
    ndarray of bool, shape (M,)
        For every edge of the axis.
    """
    if not len(axis.edges):
        return np.zeros(0, np.bool_)
    rim = np.concatenate([values[0], values[-1], values[:, 0], values[:, -1]])
    smooth = ndimage.gaussian_filter(values, max(smoothing, _LEAST_SMOOTHING), mode="nearest")
    grey = ndimage.map_coordinates(smooth, axis.points.T, order=1, mode="nearest")
    contrast = step_height(boundary.strength[axis.nearest], smoothing)
    inside = ((axis.points >= -0.5) & (axis.points <= np.array(values.shape) - 0.5)).all(axis=1)
    count, part = parts(axis)
    every = np.arange(count)
    largest = ndimage.maximum(np.where(inside, axis.radius, 0.0), part, every)
    middle = inside & (axis.radius >= _MIDDLE * largest[part])
    seen = np.isin(every, part[middle])
    difference, height = np.zeros(count), np.ones(count)
    difference[seen] = ndimage.median(np.abs(grey - np.median(rim))[middle], part[middle], every[seen])
    height[seen] = ndimage.median(contrast[middle], part[middle], every[seen])
    return np.asarray((difference > _DIFFERENT * height)[part[axis.edges[:, 0]]])
