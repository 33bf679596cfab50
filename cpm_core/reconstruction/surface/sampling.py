"""How densely points sample a surface."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array

_NEIGHBORS = 4
"""The distance to this neighbor is about that between points, in regular patterns and at random."""


def typical_distance(places: Array) -> float:
    """Typical distance between neighboring places, shape (N, 3), in their unit."""
    distances = scipy.spatial.KDTree(places).query(places, [min(_NEIGHBORS, len(places) - 1) + 1])[0]
    return float(np.median(distances))
