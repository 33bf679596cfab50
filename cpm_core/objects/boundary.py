"""Price of a boundary: what it costs that an object ends between two neighboring faces."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array
from cpm_core.objects.faces.face_graph import FaceGraph

ON_CONTOUR = 0.5
"""Price of a stretch of boundary along a contour, as a fraction of that of one without."""

SHARPNESS = 1.0
"""How fast the price of a boundary falls with the strength of the edge along it."""

LEAST = 0.005
"""Least price of a pixel of boundary, where the edge is strongest."""


def prices(graph: FaceGraph, strong: float) -> Array:
    """Price of the common border of each pair of faces, shape (E,).

    The length times ``exp(-k s / s0)`` with the edge strength s along it and k = `SHARPNESS`, at least `LEAST`, and
    times `ON_CONTOUR` for the part on a contour; nothing on a barrier. s0 is the median strength along contours,
    `strong` where there is none.
    """
    edge = np.maximum(LEAST, np.exp(-SHARPNESS * graph.strength / _typical(graph, strong)))
    along = 1.0 - (1.0 - ON_CONTOUR) * graph.along
    return np.asarray(graph.length * edge * along * (1.0 - graph.barred))


def _typical(graph: FaceGraph, strong: float) -> float:
    """Median edge strength along contours; a percentile of the whole image depends on how much of it is empty."""
    on = graph.along > 0.5
    if not on.any():
        return strong
    order = np.argsort(graph.strength[on])
    length = np.cumsum(graph.length[on][order])
    median = graph.strength[on][order][np.searchsorted(length, 0.5 * length[-1])]
    return max(float(median), 1e-300)
