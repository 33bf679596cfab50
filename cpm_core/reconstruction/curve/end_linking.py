"""Linking loose ends where the edge continues between them."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.contours.graph import Graph
from cpm_core.field.scale_field import EDGE_END_FRACTION, ScaleField

_MIN_LOOP_LENGTH = 3.0
"""Least length of the path along a curve, in lengths of the gap, for an end to be joined to its own curve."""

_SIDE_DISTANCE_FACTOR = 1.5
"""Factor by which the side of a curve must be nearer than an end to have priority: joining two ends closes a curve,
joining a side makes a junction."""

_GAP_SAMPLES = 7
"""Number of samples of the edge map across a gap."""


def link_loose_ends(graph: Graph, scale_field: ScaleField, max_gap: float) -> None:
    """Join loose ends to each other and to the sides of curves, which makes a junction; the graph is changed in place.

    The nearest pairs come first. A gap must not be wider than `max_gap` [px] and have an edge of the image across it.
    """
    ends = graph.loose_ends()
    used = np.flatnonzero(graph.degrees)
    if not len(ends):
        return
    tree = scipy.spatial.cKDTree(graph.points[used], balanced_tree=False, compact_nodes=False)
    near = scipy.spatial.cKDTree(graph.points[ends]).query_ball_tree(tree, max_gap)
    end = np.repeat(ends, [len(some) for some in near])
    other = used[np.concatenate([np.array(some, np.int64) for some in near])]
    gap = np.linalg.norm(graph.points[end] - graph.points[other], axis=1)
    open_ = (graph.path_lengths_between(end, other) > _MIN_LOOP_LENGTH * gap) & (end != other)
    end, other, gap = end[open_], other[open_], gap[open_]
    a, b = graph.points[end], graph.points[other]
    along = a[:, None] + (b - a)[:, None] * np.linspace(0.0, 1.0, _GAP_SAMPLES)[:, None]
    strength = scale_field.strength_at(along.reshape(-1, 2)).reshape(-1, _GAP_SAMPLES)
    held = strength.min(axis=1) >= EDGE_END_FRACTION * np.minimum(strength[:, 0], strength[:, -1])
    held &= ~scale_field.barrier_map.is_crossed_by(a, b)
    end, other, gap = end[held], other[held], gap[held]
    cost = np.where(graph.degrees[other] == 1, gap, _SIDE_DISTANCE_FACTOR * gap)
    order = np.lexsort((other, end, cost))
    for one, another in zip(end[order].tolist(), other[order].tolist(), strict=True):
        if graph.degree(one) == 1:
            graph.add_edge(one, another)
