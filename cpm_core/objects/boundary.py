"""Price of a boundary: what it costs that an object ends between two neighboring faces."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array
from cpm_core.objects.faces.face_graph import FaceGraph

ON_CONTOUR = 0.05
"""Price of a stretch of boundary along a contour, as a fraction of that of one without."""

LEAST = 0.03
"""Least price of a pixel of boundary, where the edge is strongest."""

_FAR, _NEAR = 30.0, 10.0
"""Distance from a place inside at which a pixel of boundary has its full price, and what is added to distances [px]."""


def prices(graph: FaceGraph, strong: float, places: Array) -> Array:
    """Price of the common border of each pair of faces, shape (E,).

    The length times ``exp(-s / s0)`` with the edge strength s along it, at least `LEAST`, and times `ON_CONTOUR` for
    the part on a contour; nothing on a barrier. s0 is the median strength along contours, `strong` where there is
    none. All that times `nearness` of the `places`, shape (M, 2), that are inside.
    """
    edge = np.maximum(LEAST, np.exp(-graph.strength / _typical(graph, strong)))
    along = 1.0 - (1.0 - ON_CONTOUR) * graph.along
    middle = 0.5 * (graph.center[graph.first] + graph.center[graph.second])
    return np.asarray(graph.length * edge * along * (1.0 - graph.barred) * nearness(middle, places))


def nearness(positions: Array, places: Array) -> Array:
    """Factor of the price at positions, shape (N, 2), which falls with the distance from the nearest place inside.

    The length of a boundary grows with its distance, so that one just around a click would always be the cheapest. The
    inverse square root of the distance makes up for half of that on a logarithmic scale: all of it lets objects run out
    to the border of the image.
    """
    away = np.asarray(scipy.spatial.cKDTree(places).query(positions)[0])
    return np.asarray(np.sqrt(_FAR / (_NEAR + away)))


def _typical(graph: FaceGraph, strong: float) -> float:
    """Median edge strength along contours; a percentile of the whole image depends on how much of it is empty."""
    on = graph.along > 0.5
    if not on.any():
        return strong
    order = np.argsort(graph.strength[on])
    length = np.cumsum(graph.length[on][order])
    median = graph.strength[on][order][np.searchsorted(length, 0.5 * length[-1])]
    return max(float(median), 1e-300)
