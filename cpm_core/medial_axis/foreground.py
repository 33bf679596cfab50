"""Sides: which parts of a medial axis lie in objects, and which in the background."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.medial_axis.blur_correction import step_height, step_width
from cpm_core.medial_axis.boundary import Boundary
from cpm_core.medial_axis.medial_axis import Axis
from cpm_core.medial_axis.pruning import parts
from cpm_core.numerics.types import Array

_CLEAR, _MIDDLE = 2.5, 0.5
"""Distance from an edge at which grey levels tell what lies beside it, in widths of its smoothed step; in parts without
room for that, fraction of the largest radius."""

_DIFFERENT = 0.25
"""Part of the contrast of an edge by which what lies behind it must differ from the background to be an object."""

_LEAST_SMOOTHING = 1.0
"""Smoothing of the grey levels that are compared [px]."""


def within_objects(axis: Axis, boundary: Boundary, values: Array, smoothing: float) -> NDArray[np.bool_]:
    """Tell which edges of an axis lie in objects.

    The background has the grey level of the image's border (the median of its outermost pixels). A connected part of
    the axis lies in an object if its grey level, beside the edges around it as well as away from them, differs from
    that by more than a quarter of their contrast, be it brighter or darker; so the hole of a ring is background again.

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
    low, high = np.full(2, -0.5), np.array(values.shape) - 0.5
    clear = _CLEAR * step_width(smoothing)
    # two places tell: the vertex itself, and one on its side of the edge and just clear of it, for behind a sharp tip
    # the object shows for some way, and far off there may be something else that has no edges
    share = np.minimum(clear / np.maximum(axis.radius, clear), 1.0)
    edge = boundary.points[axis.nearest]
    places = edge + share[:, None] * (axis.points - edge)
    rim = np.concatenate([values[0], values[-1], values[:, 0], values[:, -1]])
    smooth = scipy.ndimage.gaussian_filter(values, max(smoothing, _LEAST_SMOOTHING), mode="nearest")
    grey = [scipy.ndimage.map_coordinates(smooth, where.T, order=1, mode="nearest") for where in (places, axis.points)]
    away = np.min(np.abs(np.array(grey) - np.median(rim)), axis=0)
    contrast = step_height(boundary.strength[axis.nearest], smoothing)
    inside = axis.inside(low, high)
    count, part = parts(axis)
    every = np.arange(count)
    largest = scipy.ndimage.maximum(np.where(inside, axis.radius, 0.0), part, every)
    telling = inside & (axis.radius >= np.minimum(clear, _MIDDLE * largest[part]))
    seen = np.isin(every, part[telling])
    difference, height = np.zeros(count), np.ones(count)
    difference[seen] = scipy.ndimage.median(away[telling], part[telling], every[seen])
    height[seen] = scipy.ndimage.median(contrast[telling], part[telling], every[seen])
    return np.asarray((difference > _DIFFERENT * height)[part[axis.edges[:, 0]]])
