"""Pruning: cutting an axis back from its tips where that changes next to nothing of the shape."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.graph import Graph
from cpm_core.medial_axis.medial_axis import Axis
from cpm_core.numerics.types import Array

_SHORTEST = 1.0
"""Length under which a branch, or the way from one junction to the next, is none [px]."""


def prune(axis: Axis, pruning: float) -> Axis:
    """Cut an axis back from its tips.

    On every vertex stands a disk that reaches to the boundary; all of them together are the shape. The last vertex of
    a tip is taken away if its disk, and those of all that has been taken away behind it, stick out of the disk of the
    next vertex by at most `pruning`. So whatever the disks of an axis cover is covered by the disks that remain, grown
    by `pruning`; what hangs together goes on doing so, rounds stay, the order of the tips does not matter, and more
    `pruning` only takes more away. In the end, branches and ways between junctions of less than a pixel are taken for
    one place.

    Parameters
    ----------
    axis : Axis
        Medial axis.
    pruning : float
        How far from what remains the shape may have reached [px].

    Returns
    -------
    Axis
        What remains. Of each part without a round that is at least the vertex with the largest disk, be it by itself.
    """
    if not len(axis.edges):
        return axis
    count, part = parts(axis)
    roots = _largest(axis.radius, part, count)
    graph = Graph(axis.points, _cut_back(axis, set(roots.tolist()), pruning))
    _drop_stubs(graph)
    _merge_junctions(graph, axis.radius)
    edges = graph.edges()
    return axis.only(edges, roots[~np.isin(np.arange(count), part[edges[:, 0]])])


def parts(axis: Axis) -> tuple[int, NDArray[np.int32]]:
    """Number of connected parts of an axis, and the part that each vertex belongs to."""
    size = len(axis.points)
    joined = scipy.sparse.coo_array(
        (np.ones(len(axis.edges)), (axis.edges[:, 0], axis.edges[:, 1])), shape=(size, size)
    )
    count, part = scipy.sparse.csgraph.connected_components(joined, directed=False)
    return int(count), part


def _largest(radius: Array, part: NDArray[np.int32], count: int) -> NDArray[np.int64]:
    """Vertex with the largest disk of each part."""
    order = np.argsort(radius, kind="stable")
    largest = np.zeros(count, np.int64)
    largest[part[order]] = order  # the last one to be written stays
    return largest


def _cut_back(axis: Axis, roots: set[int], pruning: float) -> NDArray[np.int64]:
    """Edges that are left when tips have been cut back, each as far as `pruning` allows."""
    links: list[set[int]] = [set() for _ in axis.points]
    for a, b in axis.edges.tolist():
        links[a].add(b)
        links[b].add(a)
    radius = axis.radius.tolist()
    reach = axis.radius.tolist()  # how far around each vertex the shape reaches that has been taken away behind it
    tips = [v for v, near in enumerate(links) if len(near) == 1 and v not in roots]
    while tips:
        tip = tips.pop()
        (following,) = links[tip]
        reached = float(np.linalg.norm(axis.points[tip] - axis.points[following])) + reach[tip]
        if reached - radius[following] > pruning:
            continue
        links[tip].clear()
        links[following].discard(tip)
        reach[following] = max(reach[following], reached)
        if len(links[following]) == 1 and following not in roots:
            tips.append(following)
    return np.array([(v, w) for v, near in enumerate(links) for w in near if v < w], np.int64).reshape(-1, 2)


def _drop_stubs(graph: Graph) -> None:
    """Take away the shortest branches that are less than a pixel long."""
    stubs = [graph.branch(end) for end in graph.ends().tolist()]
    for stub in sorted(stubs, key=graph.length):
        path = graph.branch(int(stub[0]))  # longer by now if its junction is none any more
        if graph.degree(path[-1]) > 2 and graph.length(path) < _SHORTEST:
            graph.drop(path)


def _merge_junctions(graph: Graph, radius: Array) -> None:
    """Make one junction of two that are less than a pixel apart: the one with the larger disk."""
    walks = graph.ways()
    short = np.flatnonzero(~walks.closed & (walks.lengths < _SHORTEST))
    moved: dict[int, int] = {}
    for n in short[np.argsort(walks.lengths[short], kind="stable")].tolist():
        way = walks.path(n)
        ends = [moved.get(v, v) for v in way[[0, -1]].tolist()]
        path = np.array([ends[0], *way[1:-1], ends[1]])
        if ends[0] == ends[1] or min(map(graph.degree, ends)) < 3 or graph.length(path) >= _SHORTEST:
            continue
        kept, lost = sorted(ends, key=lambda v: -radius[v])
        graph.drop(path)
        for v in graph.neighbors(lost):
            graph.unlink((lost, v))
            graph.link(kept, v)
        moved = {a: kept if b == lost else b for a, b in moved.items()} | {lost: kept}
