"""Foreground: which parts of a medial axis lie in objects, and which in the background."""

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
"""Distance from an edge at which gray levels are compared, in widths of its smoothed step; in narrower parts, the
fraction of the largest radius."""

_DIFFERENT = 0.25
"""Fraction of an edge's contrast by which an object must differ from the background."""

_LEAST_SMOOTHING = 1.0
"""Least smoothing of the compared gray levels [px]."""


def within_objects(axis: Axis, boundary: Boundary, values: Array, smoothing: float) -> NDArray[np.bool_]:
    """Find the edges of an axis that lie in objects.

    The gray level of the background is the median at the image border. A connected part of the axis lies in an object
    if its gray level, near the surrounding edges as well as away from them, differs from the background by more than a
    quarter of the contrast of these edges, brighter or darker; so the hole of a ring is background.

    Parameters
    ----------
    axis, boundary
        Medial axis of all regions, and the edges between them.
    values : ndarray, shape (H, W)
        Gray values of the image.
    smoothing : float
        Sigma of the edge map [px].

    Returns
    -------
    ndarray of bool, shape (M,)
        For every edge of the axis.
    """
    if not len(axis.edges):
        return np.zeros(0, np.bool_)
    low, high = np.full(2, -0.5), np.array(values.shape) - 0.5
    clear = _CLEAR * step_width(smoothing)
    # two positions are compared: the vertex itself and one just beside the edge, since beyond a sharp tip the object
    # is still visible for some distance, and far away there may be something else without edges
    share = np.minimum(clear / np.maximum(axis.radius, clear), 1.0)
    edge = boundary.points[axis.nearest]
    places = edge + share[:, None] * (axis.points - edge)
    border = np.concatenate([values[0], values[-1], values[:, 0], values[:, -1]])
    smooth = scipy.ndimage.gaussian_filter(values, max(smoothing, _LEAST_SMOOTHING), mode="nearest")
    gray = [scipy.ndimage.map_coordinates(smooth, where.T, order=1, mode="nearest") for where in (places, axis.points)]
    away = np.min(np.abs(np.array(gray) - np.median(border)), axis=0)
    contrast = step_height(boundary.strength[axis.nearest], smoothing)
    inside = axis.inside(low, high)
    count, part = parts(axis)
    every = np.arange(count)
    largest = scipy.ndimage.maximum(np.where(inside, axis.radius, 0.0), part, every)
    reliable = inside & (axis.radius >= np.minimum(clear, _MIDDLE * largest[part]))
    seen = np.isin(every, part[reliable])
    difference, height = np.zeros(count), np.ones(count)
    difference[seen] = scipy.ndimage.median(away[reliable], part[reliable], every[seen])
    height[seen] = scipy.ndimage.median(contrast[reliable], part[reliable], every[seen])
    return np.asarray((difference > _DIFFERENT * height)[part[axis.edges[:, 0]]])
