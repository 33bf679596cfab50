"""The graph of points and edges from which contours are read."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.numerics.grids import label_joined_pairs
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.polyline import lengths_along, pair_neighbors, path_length, repeat_indices
from cpm_core.numerics.types import Array, Index, Mask, record

_MIN_PASS_DETOUR = 3.0
"""Least length along the graph between two vertices at which paths pass each other, in largest distances of the two."""


class Graph:
    """Points joined by edges, and operations that simplify the graph.

    The operations work on whole paths, since nearly all vertices have two edges.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Vertices.
    edges : ndarray of int64, shape (E, 2)
        Pairs of indices.
    """

    def __init__(self, points: Array, edges: Index) -> None:
        self.points = points
        one, other = edges.astype(np.int64).reshape(-1, 2).T
        count = max(len(points), 1)
        key = np.unique(np.concatenate([one * count + other, other * count + one]))
        one, other = np.divmod(key, count)  # every edge once in both directions, sorted
        first = np.searchsorted(one, np.arange(len(points)))
        slot = np.arange(len(one)) - first[one]
        self._near = np.full((len(points), int(slot.max(initial=2)) + 1), -1, np.int64)
        """Neighbors of each vertex in any order; -1 is an empty slot."""
        self._near[one, slot] = other
        self.degrees = np.bincount(one, minlength=len(points))
        """Number of edges at each vertex, shape (N,)."""
        self._paths: GraphPaths | None = None

    def add_edge(self, a: int, b: int) -> None:
        """Join two vertices."""
        for one, other in ((a, b), (b, a)):
            near = self._near[one].tolist()
            if other in near:
                continue
            if -1 not in near:
                self._near = np.pad(self._near, [(0, 0), (0, 1)], constant_values=-1)
                near.append(-1)
            self._near[one, near.index(-1)] = other
            self.degrees[one] += 1
        self._paths = None

    def add_path(self, a: int, between: Array, b: int) -> None:
        """Join two vertices through new ones at positions of shape (K, 2)."""
        first, count = len(self.points), len(between)
        self.points = np.concatenate([self.points, between])
        self._near = np.pad(self._near, [(0, count), (0, 0)], constant_values=-1)
        self.degrees = np.pad(self.degrees, (0, count))
        for one, other in pairwise([a, *range(first, first + count), b]):
            self.add_edge(one, other)

    def remove_edges(self, edges: ArrayLike) -> None:
        """Remove the existing ones of distinct edges, shape (E, 2)."""
        pairs = np.asarray(edges, np.int64).reshape(-1, 2)
        pairs = pairs[(self._near[pairs[:, 0]] == pairs[:, 1:]).any(axis=1)]
        for one, other in (pairs.T, pairs.T[::-1]):
            self._near[one, np.argmax(self._near[one] == other[:, None], axis=1)] = -1
        np.subtract.at(self.degrees, pairs.ravel(), 1)
        self._paths = None

    def remove_path(self, path: Index) -> None:
        """Remove the edges along a path."""
        self.remove_edges(pair_neighbors(path))

    def distance_between(self, a: int, b: int) -> float:
        """Measure the distance of two vertices [px]."""
        return float(np.linalg.norm(self.points[a] - self.points[b]))

    def degree(self, vertex: int) -> int:
        """Count the edges at a vertex."""
        return int(self.degrees[vertex])

    def neighbors(self, vertex: int) -> list[int]:
        """List the neighbors of a vertex, the lowest number first."""
        return sorted(v for v in self._near[vertex].tolist() if v >= 0)

    def edges(self) -> Index:
        """List every edge once, shape (E, 2), the lower index first, sorted."""
        one, slot = np.nonzero(self._near > np.arange(len(self._near))[:, None])
        other = self._near[one, slot]
        order = np.lexsort((other, one))
        return np.stack([one[order], other[order]], axis=1)

    def loose_ends(self) -> Index:
        """List the vertices with a single edge, shape (M,)."""
        return np.flatnonzero(self.degrees == 1)

    def find_paths(self) -> GraphPaths:
        """Find the paths between ends and junctions, then the cycles.

        They begin at the ends and junctions, then at the other vertices, in the order of their numbers, toward the
        neighbor with the lowest number.
        """
        if self._paths is None:
            total = self.degrees.sum()  # each edge twice: room for its two vertices
            vertices, start = np.empty(total, np.int64), np.zeros(total // 2 + 1, np.int64)
            closed = np.zeros(total // 2, bool)
            near = np.sort(self._near, axis=1)
            count = _trace_all_paths(near, self.degrees, np.zeros(near.shape, bool), vertices, start, closed)
            start, closed = start[: count + 1], closed[:count]
            self._paths = GraphPaths(self.points, vertices[: start[-1]], start, closed)
        return self._paths

    def label_components(self) -> Index:
        """Label the connected parts of the graph; return the part of each path, shape (W,)."""
        ways = self.find_paths()
        return label_joined_pairs((ways.first, ways.last), len(self.points))[ways.first]

    def branch_from(self, end: int) -> Index:
        """Trace the path from a loose end to the next end or junction, both included, shape (K,)."""
        near = self.neighbors(end)
        if not near:
            return np.array([end])
        path = np.empty(len(self.points) + 1, np.int64)
        count = trace_path(self._near, self.degrees, np.zeros(self._near.shape, bool), end, near[0], path)
        return path[:count]

    def path_lengths_between(self, end: Index, other: Index) -> Array:
        """Measure the path length from loose ends to other vertices, shapes (N,) [px].

        It is taken along the branch of the end, and infinite for vertices off it.
        """
        ways = self.find_paths()
        along = lengths_along(self.points[ways.vertices])
        way = repeat_indices(np.diff(ways.start))
        place = np.empty(len(self.points), np.int64)
        place[ways.vertices] = np.arange(len(way))  # a junction has several places; they are not used
        own = way[place[end]]
        within = (self.degrees[other] <= 2) & (way[place[other]] == own)
        behind = (self.degrees[other] > 2) & ((ways.first[own] == other) | (ways.last[own] == other))
        length = np.where(within, np.abs(along[place[other]] - along[place[end]]), np.inf)
        return np.where(behind, ways.lengths[own], length)

    def drop_spurs(self, max_length: float) -> None:
        """Remove branches with a loose end, up to a length of `max_length` [px], shortest first."""
        ways, degrees = self.find_paths(), self.degrees
        first, last = ways.first, ways.last
        backwards = degrees[last] == 1
        end, other = np.where(backwards, last, first), np.where(backwards, first, last)
        spurs = np.flatnonzero((degrees[end] == 1) & (degrees[other] >= 3) & (ways.lengths <= max_length))
        for way in spurs[np.lexsort((end[spurs], ways.lengths[spurs]))].tolist():
            path = ways.path_vertices(way)[:: -1 if backwards[way] else 1]
            if self.degree(path[-1]) == 2:  # no longer a junction: the branch continues
                path = self.branch_from(int(path[0]))
                if self.path_length(path) > max_length:
                    continue
            if self.degree(path[-1]) >= 3:
                self.remove_path(path)

    def drop_specks(self, max_length: float) -> None:
        """Remove isolated open curves up to a length of `max_length` [px]."""
        ways = self.find_paths()
        alone = (self.degrees[ways.first] == 1) & (self.degrees[ways.last] == 1)
        self.drop_paths(alone & (ways.lengths <= max_length))

    def drop_paths(self, gone: Mask) -> None:
        """Remove the paths that a mask of shape (W,) selects."""
        if gone.any():
            edges, way = self.find_paths().path_edges()
            self.remove_edges(edges[gone[way]])

    def merge_junctions(self, max_length: float, weights: Array | None = None) -> None:
        """Merge junctions that are joined by a path up to a length of `max_length` [px].

        They meet halfway, or with `weights`, shape (N,), at the one with the larger weight.
        """
        ways = self.find_paths()
        self.points = self.points.copy()
        moved: set[int] = set()
        for way in self._junction_links(ways).tolist():
            path = ways.path_vertices(way)
            kept, gone = int(path[0]), int(path[-1])
            if ways.lengths[way] > max_length and not moved & {kept, gone}:
                continue
            intact = (self._near[path[:-1]] == path[1:, None]).any(axis=1).all()
            if not intact or min(map(self.degree, (kept, gone))) < 3 or self.path_length(path) > max_length:
                continue
            self.remove_path(path)
            if weights is None:
                self.points[kept] = 0.5 * (self.points[kept] + self.points[gone])
                moved.add(kept)
            elif weights[gone] > weights[kept]:
                kept, gone = gone, kept
            for other in self.neighbors(gone):
                self.remove_edges((gone, other))
                if other != kept:
                    self.add_edge(kept, other)

    def drop_junction_links(self, max_length: float) -> list[Array]:
        """Remove paths between two junctions that are shorter than `max_length` [px], shortest first, and return them.

        Such links occur at the mouth of a narrow slit, where they connect its two sides.
        """
        ways = self.find_paths()
        ties = self._junction_links(ways)
        ties = ties[ways.lengths[ties] < max_length]
        dropped = []
        for way in ties[np.argsort(ways.lengths[ties], kind="stable")].tolist():
            path = ways.path_vertices(way)
            if min(map(self.degree, (path[0], path[-1]))) > 2:
                self.remove_path(path)
                dropped.append(self.points[path])
        return dropped

    def find_passes(self, max_distance: float) -> Array:
        """Find where two paths pass each other within `max_distance` [px]; the two places of each, shape (N, 2, 2).

        Along one path the two places, and the ends of two from them, are at least `_MIN_PASS_DETOUR` times as far.
        """
        ways = self.find_paths()
        inner = np.flatnonzero(self.degrees == 2)
        if not len(inner):
            return np.empty((0, 2, 2))
        pairs = inner[scipy.spatial.cKDTree(self.points[inner]).query_pairs(max_distance, output_type="ndarray")]
        along, way = lengths_along(self.points[ways.vertices]), repeat_indices(np.diff(ways.start))
        along -= along[ways.start[way]]
        place = np.empty(len(self.points), np.int64)
        place[ways.vertices] = np.arange(len(way))  # a junction has several places; they are not used
        own, first = way[place[pairs]], along[place[pairs]]
        length = ways.lengths[own]
        apart = np.abs(first[:, 0] - first[:, 1])
        apart = np.where(ways.closed[own[:, 0]], np.minimum(apart, length[:, 0] - apart), apart)
        to_end = np.where(ways.closed[own], np.inf, np.minimum(first, length - first)).min(axis=1)
        detour = np.where(own[:, 0] == own[:, 1], apart, to_end)
        found = self.points[pairs[detour > _MIN_PASS_DETOUR * max_distance]]
        nearest = np.argsort(np.linalg.norm(found[:, 0] - found[:, 1], axis=1), kind="stable")
        passes = np.empty((0, 2, 2))
        for one in found[nearest]:
            away = np.linalg.norm((passes - one).mean(axis=1), axis=1)
            if (away > _MIN_PASS_DETOUR * max_distance).all():
                passes = np.concatenate([passes, one[None]])
        return passes

    def _junction_links(self, ways: GraphPaths) -> Index:
        """List the paths between two junctions."""
        return np.flatnonzero(~ways.closed & (self.degrees[ways.first] > 2) & (self.degrees[ways.last] > 2))

    def path_length(self, path: Index) -> float:
        """Measure the length of a path [px]."""
        return path_length(self.points[path])

    def extract_contours(self, min_length: float = 0.0) -> tuple[Contour, ...]:
        """Extract the contours with a length of at least `min_length` [px], longest first.

        A cycle is closed even if dead ends branch off it.
        """
        ways = self.find_paths()
        forks = np.stack([self.degrees[ways.first] > 2, self.degrees[ways.last] > 2], axis=1) & ~ways.closed[:, None]
        rings, in_ring = self._find_rings(forks[:, 0] & forks[:, 1])
        long = np.flatnonzero(rings.closed & (rings.lengths >= min_length))
        found = [Contour(self.points[rings.path_vertices(ring)], True) for ring in long.tolist()]
        for way in np.flatnonzero((ways.lengths >= min_length) & ~in_ring).tolist():
            before, behind = forks[way].tolist()
            found.append(
                Contour(self.points[ways.path_vertices(way)], bool(ways.closed[way]), junctions=(before, behind))
            )
        return tuple(sorted(found, key=lambda contour: -contour.length))

    def _find_rings(self, between: Mask) -> tuple[GraphPaths, Mask]:
        """Find the cycles of the paths `between` junctions without dead ends; mark the paths on them, shape (W,)."""
        edges, way = self.find_paths().path_edges()
        rest = Graph(self.points, edges[between[way]])
        rest.drop_spurs(np.inf)
        ways = rest.find_paths()
        around, ring = ways.path_edges()
        part = np.isin(self._edge_keys(edges), self._edge_keys(around[ways.closed[ring]]))
        return ways, np.bincount(way[part], minlength=len(between)) > 0

    def _edge_keys(self, edges: Index) -> Index:
        """Compute a key for each edge, independent of its direction."""
        return np.sort(edges, axis=1) @ (len(self.points), 1)


@record
class GraphPaths:
    """Paths between ends and junctions, then cycles; every edge of a graph is in exactly one.

    Attributes
    ----------
    points : ndarray, shape (N, 2)
        Places of the vertices [px].
    vertices : ndarray of int64
        The vertices of all paths in order; the first is not repeated at the end of a cycle.
    start : ndarray of int64, shape (W + 1,)
        Index in `vertices` at which each path begins, and at which the last one ends.
    closed : ndarray of bool, shape (W,)
        Which paths are cycles, including those through one junction.
    """

    points: Array
    vertices: Index
    start: Index
    closed: Mask

    def __len__(self) -> int:
        return len(self.closed)

    @cached_property
    def lengths(self) -> Array:
        """Lengths of the paths [px], of cycles including the edge from the last vertex to the first, shape (W,)."""
        edges, way = self.path_edges()
        sides = self.points[edges[:, 0]] - self.points[edges[:, 1]]
        return np.bincount(way, np.linalg.norm(sides, axis=1), len(self)).astype(float)

    @property
    def first(self) -> Index:
        """First vertex of each path."""
        return self.vertices[self.start[:-1]]

    @property
    def last(self) -> Index:
        """Last vertex of each path."""
        return self.vertices[self.start[1:] - 1]

    def path_vertices(self, way: int) -> Index:
        """List the vertices of a path, shape (K,)."""
        return self.vertices[self.start[way] : self.start[way + 1]]

    def path_edges(self) -> tuple[Index, Index]:
        """List the edges of all paths in order, shape (E, 2), and the path of each edge, shape (E,)."""
        way = repeat_indices(np.diff(self.start))
        following = np.roll(self.vertices, -1)
        following[self.start[1:] - 1] = np.where(self.closed, self.first, -1)
        kept = following >= 0
        return np.stack([self.vertices[kept], following[kept]], axis=1), way[kept]


@compiled
def _trace_all_paths(
    near: Index,
    degrees: Index,
    walked: Mask,
    vertices: Index,
    start: Index,
    closed: Mask,
) -> int:
    """Write all paths and return their number; `walked` marks the edges, shape (N, K), that a path has used.

    Rows of `near` are sorted.
    """
    count, filled = 0, 0
    for rounds in range(2):
        for v in range(len(near)):
            if (degrees[v] == 2) != (rounds == 1):
                continue
            for slot in range(near.shape[1]):
                if near[v, slot] < 0 or walked[v, slot]:
                    continue
                length = trace_path(near, degrees, walked, v, near[v, slot], vertices[filled:])
                closed[count] = vertices[filled + length - 1] == v
                filled += length - 1 if closed[count] else length
                count += 1
                start[count] = filled
    return count


@compiled
def trace_path(near: Index, degrees: Index, walked: Mask, first: int, towards: int, out: Index) -> int:
    """Write the path from a vertex toward a neighbor, up to the next end or junction or itself; return its size.

    `near`, shape (N, K), holds the neighbors of each vertex, `degrees`, shape (N,), their numbers; `walked`, shape
    (N, K), marks the used edges, and `out` takes the vertices.
    """
    out[0] = first
    before, vertex, count = first, towards, 1
    while True:
        out[count] = vertex
        count += 1
        for k in range(near.shape[1]):
            if near[before, k] == vertex:
                walked[before, k] = True
            if near[vertex, k] == before:
                walked[vertex, k] = True
        if vertex == first or degrees[vertex] != 2:
            return count
        ahead = vertex
        for k in range(near.shape[1]):
            if near[vertex, k] >= 0 and near[vertex, k] != before:
                ahead = near[vertex, k]
        before, vertex = vertex, ahead
