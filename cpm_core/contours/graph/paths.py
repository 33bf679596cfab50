"""The paths of a graph: from one end or junction to the next, and cycles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index


@dataclass(frozen=True, eq=False, slots=True)
class Ways:
    """Paths between ends and junctions, then cycles: every edge of a graph once.

    Attributes
    ----------
    vertices : ndarray of int64
        The vertices of all paths in order; the first is not repeated at the end of a cycle.
    start : ndarray of int64, shape (W + 1,)
        Index in `vertices` at which each path begins, and at which the last one ends.
    closed : ndarray of bool, shape (W,)
        Which paths are cycles, including those through one junction.
    lengths : ndarray, shape (W,)
        Lengths [px], of cycles including the edge from the last vertex to the first.
    """

    vertices: Index
    start: Index
    closed: NDArray[np.bool_]
    lengths: Array

    def __len__(self) -> int:
        return len(self.closed)

    @property
    def first(self) -> Index:
        """First vertex of each path."""
        return self.vertices[self.start[:-1]]

    @property
    def last(self) -> Index:
        """Last vertex of each path."""
        return self.vertices[self.start[1:] - 1]

    def path(self, way: int) -> Index:
        """Vertices of a path."""
        return self.vertices[self.start[way] : self.start[way + 1]]

    def edges(self) -> tuple[Index, Index]:
        """Edges of all paths in order, shape (E, 2), and the path of each edge, shape (E,)."""
        way = np.repeat(np.arange(len(self)), np.diff(self.start))
        following = np.roll(self.vertices, -1)
        following[self.start[1:] - 1] = np.where(self.closed, self.first, -1)
        kept = following >= 0
        return np.stack([self.vertices[kept], following[kept]], axis=1), way[kept]


def ways_of(points: Array, near: Index, degrees: Index) -> Ways:
    """The paths of a graph of points, shape (N, 2), with their neighbors or -1, shape (N, K), and degrees, shape (N,).

    Paths begin at the ends and junctions, then at the other vertices, in the order of their numbers, toward the
    neighbor with the lowest number.
    """
    total = int(degrees.sum())  # each edge twice: room for its two vertices
    vertices, start = np.empty(total, np.int64), np.zeros(total // 2 + 1, np.int64)
    closed = np.zeros(total // 2, np.bool_)
    count = _walk_all(near, degrees, np.zeros(near.shape, np.bool_), vertices, start, closed)
    start, closed = start[: count + 1], closed[:count]
    vertices = vertices[: start[-1]]
    ways = Ways(vertices, start, closed, np.zeros(count))
    edges, way = ways.edges()
    sides = points[edges[:, 0]] - points[edges[:, 1]]
    lengths = np.bincount(way, np.linalg.norm(sides, axis=1), count)
    return Ways(vertices, start, closed, np.asarray(lengths, dtype=float))


@compiled
def _walk_all(
    near: Index,
    degrees: Index,
    walked: NDArray[np.bool_],
    vertices: Index,
    start: Index,
    closed: NDArray[np.bool_],
) -> int:
    """Write all paths and return their number; `walked` marks the edges, shape (N, K), that a path has used."""
    count, filled = 0, 0
    for rounds in range(2):
        for v in range(len(near)):
            if (degrees[v] == 2) != (rounds == 1):
                continue
            before = -1
            for _ in range(degrees[v]):
                # the neighbor with the next higher number
                slot = -1
                for k in range(near.shape[1]):
                    if near[v, k] > before and (slot < 0 or near[v, k] < near[v, slot]):
                        slot = k
                before = near[v, slot]
                if walked[v, slot]:
                    continue
                length = follow(near, degrees, walked, v, before, vertices[filled:])
                closed[count] = vertices[filled + length - 1] == v
                filled += length - 1 if closed[count] else length
                count += 1
                start[count] = filled
    return count


@compiled
def follow(near: Index, degrees: Index, walked: NDArray[np.bool_], first: int, towards: int, out: Index) -> int:
    """Write the path from a vertex toward a neighbor, up to the next end or junction or itself; return its size."""
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
