"""Pruning: shortening an axis from its tips where that hardly changes the shape."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.contours.graph.graph import Graph
from cpm_core.medial_axis.medial_axis import Axis
from cpm_core.numerics.types import Array

_SHORTEST = 1.0
"""Least length of a branch, and of a path between two junctions [px]."""


def prune(axis: Axis, pruning: float) -> Axis:
    """Shorten an axis from its tips.

    Every vertex is the center of a disk that reaches to the boundary; their union is the shape. The last vertex of a
    tip is removed if its disk, and the disks removed before it, extend beyond the disk of the next vertex by at most
    `pruning` [px]. So the remaining disks, enlarged by `pruning`, cover the whole shape. Connected parts stay
    connected, cycles stay, the order of the tips has no effect, and a larger `pruning` removes more. Then branches
    shorter than a pixel are dropped and junctions nearer than that are merged. Of each part without a cycle at least
    the vertex with the largest disk remains.
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
    largest[part[order]] = order  # the last value written is kept
    return largest


def _cut_back(axis: Axis, roots: set[int], pruning: float) -> NDArray[np.int64]:
    """Edges that remain when every tip is shortened as far as `pruning` allows."""
    links: list[set[int]] = [set() for _ in axis.points]
    for a, b in axis.edges.tolist():
        links[a].add(b)
        links[b].add(a)
    radius = axis.radius.tolist()
    reach = axis.radius.tolist()  # how far the shape removed behind a vertex reaches around it
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
    """Remove branches shorter than a pixel, the shortest first."""
    stubs = [graph.branch(end) for end in graph.ends().tolist()]
    for stub in sorted(stubs, key=graph.length):
        path = graph.branch(int(stub[0]))  # longer if its junction has become a plain vertex
        if graph.degree(path[-1]) > 2 and graph.length(path) < _SHORTEST:
            graph.drop(path)


def _merge_junctions(graph: Graph, radius: Array) -> None:
    """Merge junctions less than a pixel apart into the one with the larger disk."""
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
