"""Joining loose ends where the edge goes on between them."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.level import FAINTEST, Level
from cpm_core.reconstruction.graph import Graph

Array = NDArray[np.float64]

_DETOUR = 3.0
"""How many times as long as the gap the way along the curve must be for an end to be joined to its own curve."""

_SIDE = 1.5
"""How many times nearer than an end the side of a curve must be to be preferred: joining two ends closes a curve,
joining a side makes a junction."""

_SAMPLES = 7
"""Places across a gap at which the edge map is read."""


def close_gaps(graph: Graph, level: Level, reach: float) -> None:
    """Join loose ends to each other, and to curves that they run into.

    The nearest pairs come first. A gap must be no wider than `reach` and have an edge of the image across it; it lies
    between two ends, or between an end and the side of a curve, which makes a junction.

    Parameters
    ----------
    graph : Graph
        Changed in place.
    level : Level
        Fields of the scale.
    reach : float
        Widest gap [px].
    """
    ends = graph.ends()
    if not ends:
        return
    used = [v for v in range(len(graph.links)) if graph.degree(v) > 0]
    tree = scipy.spatial.cKDTree(graph.points[used])
    pairs = []
    for end in ends:
        way = graph.way_from(end)
        for n in tree.query_ball_point(graph.points[end], reach):
            other = used[n]
            gap = graph.distance(end, other)
            if way.get(other, np.inf) > _DETOUR * gap:
                pairs.append((gap if graph.degree(other) == 1 else _SIDE * gap, end, other))
    for _, end, other in sorted(pairs):
        if graph.degree(end) == 1 and _edge_between(graph.points[end], graph.points[other], level):
            graph.link(end, other)


def _edge_between(a: Array, b: Array, level: Level) -> bool:
    """Whether the edge map stays up on the way from a to b, and no wall is in it."""
    along = a + (b - a) * np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    strength = level.strength(along)
    goes_on = strength.min() >= FAINTEST * min(strength[0], strength[-1])
    return bool(goes_on and not level.walls.crossed(a[None], b[None]).any())
