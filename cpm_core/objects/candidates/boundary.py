"""Price of a boundary: what it costs that an object ends between two neighboring faces."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array
from cpm_core.objects.faces.face_graph import FaceGraph

ON_CONTOUR = 0.5
"""Price of a stretch of boundary along a contour, as a fraction of that of one without."""

SHARPNESS = 3.0
"""How fast the price of a boundary falls with the strength of the edge along it."""

LEAST = 0.005
"""Least price of a pixel of boundary, where the edge is strongest."""


def prices(graph: FaceGraph, strong: float) -> Array:
    """Price of the common border of each pair of faces, shape (E,).

    The length times ``exp(-k s / strong)`` with the edge strength s along it and k = `SHARPNESS`, at least `LEAST`, and
    times `ON_CONTOUR` for the part on a contour; nothing on a barrier.
    """
    edge = np.maximum(LEAST, np.exp(-SHARPNESS * graph.strength / max(strong, 1e-300)))
    along = 1.0 - (1.0 - ON_CONTOUR) * graph.along
    return np.asarray(graph.length * edge * along * (1.0 - graph.barred))
