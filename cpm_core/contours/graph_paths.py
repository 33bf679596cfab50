"""The ways of a graph: what its edges are walked along, from one end or junction to the next, and round and round."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index


@dataclass(frozen=True, eq=False, slots=True)
class Ways:
    """Paths between vertices that have not exactly two edges, then closed rounds: every edge of a graph once.

    Attributes
    ----------
    vertices : ndarray of int64
        Those of one way after the other, in order; the first is not repeated at the end of a round.
    start : ndarray of int64, shape (W + 1,)
        Where in `vertices` each way begins, and where the last one ends.
    closed : ndarray of bool, shape (W,)
        Which ways are rounds, be it through one junction.
    lengths : ndarray, shape (W,)
        Lengths [px], those of rounds with the edge from the last vertex to the first.
    """

    vertices: Index
    start: Index
    closed: NDArray[np.bool_]
    lengths: Array

    def __len__(self) -> int:
        return len(self.closed)

    @property
    def first(self) -> Index:
        """First vertex of each way."""
        return self.vertices[self.start[:-1]]

    @property
    def last(self) -> Index:
        """Last vertex of each way."""
        return self.vertices[self.start[1:] - 1]

    def path(self, way: int) -> Index:
        """Vertices of a way."""
        return self.vertices[self.start[way] : self.start[way + 1]]

    def edges(self) -> tuple[Index, Index]:
        """Edges of all ways, shape (E, 2), in order along each, and the way that each belongs to, shape (E,)."""
        way = np.repeat(np.arange(len(self)), np.diff(self.start))
        following = np.roll(self.vertices, -1)
        following[self.start[1:] - 1] = np.where(self.closed, self.first, -1)
        kept = following >= 0
        return np.stack([self.vertices[kept], following[kept]], axis=1), way[kept]


def ways_of(points: Array, near: Index, degrees: Index) -> Ways:
    """Walk along all edges of a graph.

    Walks begin at the vertex with the lowest number and go towards its neighbor with the lowest number, first from
    those that have not exactly two edges.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Vertices [px].
    near : ndarray of int64, shape (N, K)
        The neighbors of each in any order, and -1.
    degrees : ndarray of int64, shape (N,)
        How many neighbors each has.

    Returns
    -------
    Ways
        The paths between ends and junctions, then the rounds.
    """
    total = int(degrees.sum())  # each edge twice: room for its two vertices by themselves
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
    """Write all ways and return how many they are; `walked` says of each neighbor whether one has come from there."""
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
    """Write the path from a vertex towards a neighbor, up to the next that has not exactly two edges, or itself.

    Returns how many vertices it has, both ends counted.
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
