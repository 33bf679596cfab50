"""Joining loose ends where the edge goes on between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from cpm_core.level import FAINTEST, Level
from cpm_core.reconstruction.graph import Graph

Array = NDArray[np.float64]

_DETOUR = 3.0
"""How many times as long as the bridge the way along the curve must be for an end to be joined to its own curve."""

_SIDE = 1.5
"""How many times nearer than an end the side of a curve must be to be preferred: joining two ends closes a curve,
joining a side makes a junction."""

_SAMPLES = 7
"""Places along a bridge at which the edge map is read."""


def close_gaps(graph: Graph, level: Level, reach: float) -> None:
    """Join loose ends to each other, and to curves that they run into.

    The nearest pairs come first. A bridge must be no longer than `reach` and have an edge of the image under it; it
    joins two ends, or an end to the side of a curve, which makes a junction.

    Parameters
    ----------
    graph : Graph
        Changed in place.
    level : Level
        Fields of the scale.
    reach : float
        Longest bridge [px].
    """
    ends = [v for v in range(len(graph.links)) if graph.degree(v) == 1]
    if not ends:
        return
    used = [v for v in range(len(graph.links)) if graph.degree(v) > 0]
    tree = cKDTree(graph.points[used])
    pairs = []
    for end in ends:
        way = _lengths(graph, graph.branch(end))
        for n in tree.query_ball_point(graph.points[end], reach):
            other = used[n]
            bridge = graph.distance(end, other)
            if way.get(other, np.inf) > _DETOUR * bridge:
                pairs.append((bridge if graph.degree(other) == 1 else _SIDE * bridge, end, other))
    for _, end, other in sorted(pairs):
        if graph.degree(end) == 1 and _edge_between(graph.points[end], graph.points[other], level):
            graph.link(end, other)


def _lengths(graph: Graph, path: list[int]) -> dict[int, float]:
    """Length of the way along a path to each of its vertices."""
    steps = np.linalg.norm(np.diff(graph.points[path], axis=0), axis=1)
    return dict(zip(path, [0.0, *np.cumsum(steps).tolist()], strict=True))


def _edge_between(a: Array, b: Array, level: Level) -> bool:
    """Whether the edge map stays up on the way from a to b, and no wall is in it."""
    along = a + (b - a) * np.linspace(0.0, 1.0, _SAMPLES)[:, None]
    strength = level.strength(along)
    goes_on = strength.min() >= FAINTEST * min(strength[0], strength[-1])
    return bool(goes_on and not level.walls.crossed(a[None], b[None]).any())
