"""The graph of points and edges that contours are walked from."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from cpm_core.contour import Contour, lengths_along

Array = NDArray[np.float64]
Edges = NDArray[np.int64]


class Graph:
    """Points joined by edges, with what it takes to tidy them up.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Vertices.
    edges : ndarray of int64, shape (E, 2)
        Pairs of indices.
    """

    def __init__(self, points: Array, edges: Edges) -> None:
        self.points = points
        self.links: list[set[int]] = [set() for _ in range(len(points))]
        for a, b in edges.tolist():
            self.link(a, b)

    def link(self, a: int, b: int) -> None:
        """Join two vertices."""
        self.links[a].add(b)
        self.links[b].add(a)

    def insert(self, a: int, between: Array, b: int) -> None:
        """Join two vertices by way of new ones, shape (K, 2)."""
        first = len(self.points)
        self.points = np.concatenate([self.points, between])
        self.links.extend(set() for _ in between)
        for one, other in pairwise([a, *range(first, first + len(between)), b]):
            self.link(one, other)

    def unlink(self, a: int, b: int) -> None:
        """Part two vertices."""
        self.links[a].discard(b)
        self.links[b].discard(a)

    def distance(self, a: int, b: int) -> float:
        """Distance of two vertices [px]."""
        return float(np.linalg.norm(self.points[a] - self.points[b]))

    def degree(self, vertex: int) -> int:
        """Number of edges at a vertex."""
        return len(self.links[vertex])

    def edges(self) -> Edges:
        """Every edge once, shape (E, 2), the lower index first."""
        pairs = [(a, b) for a, near in enumerate(self.links) for b in sorted(near) if a < b]
        return np.array(pairs, dtype=np.int64).reshape(-1, 2)

    def ends(self) -> list[int]:
        """Vertices with a single edge."""
        return [v for v, near in enumerate(self.links) if len(near) == 1]

    def branch(self, end: int) -> list[int]:
        """Vertices from a loose end up to the first that has not exactly two edges, both included."""
        path, before, vertex = [end], -1, end
        while True:
            ahead = [w for w in self.links[vertex] if w != before]
            if not ahead or (vertex != end and self.degree(vertex) != 2):
                return path
            before, vertex = vertex, ahead[0]
            path.append(vertex)

    def way_from(self, end: int) -> dict[int, float]:
        """Length of the way along the branch of a loose end to each of its vertices [px]."""
        path = self.branch(end)
        return dict(zip(path, lengths_along(self.points[path]).tolist(), strict=True))

    def drop_spurs(self, longest: float) -> None:
        """Take away branches of a length of at most `longest` [px] that hang loose from a junction, shortest first."""
        for end in sorted(self.ends(), key=lambda end: self.length(self.branch(end))):
            path = self.branch(end) if self.degree(end) == 1 else [end]
            if self.degree(path[-1]) >= 3 and self.length(path) <= longest:
                self._drop(path)

    def drop_specks(self, longest: float) -> None:
        """Take away open curves of a length of at most `longest` [px] that are connected to nothing."""
        for end in self.ends():
            path = self.branch(end) if self.degree(end) == 1 else [end]
            if self.degree(path[-1]) == 1 and self.length(path) <= longest:
                self._drop(path)

    def merge_junctions(self, longest: float) -> None:
        """Make one junction of two that are joined by a way of a length of at most `longest` [px]."""
        self.points = self.points.copy()
        for path in self._ties():
            kept, gone = path[0], path[-1]
            intact = all(b in self.links[a] for a, b in pairwise(path))
            if not intact or min(map(self.degree, (kept, gone))) < 3 or self.length(path) > longest:
                continue
            self._drop(path)
            self.points[kept] = 0.5 * (self.points[kept] + self.points[gone])
            for other in sorted(self.links[gone]):
                self.unlink(gone, other)
                if other != kept:
                    self.link(kept, other)

    def drop_ties(self, longest: float) -> None:
        """Take away ways of a length of less than `longest` [px] from one junction to another, shortest first.

        What they hang between then goes on without them: at the mouth of a narrow slit they tie its two sides together.
        """
        for path in sorted(self._ties(), key=self.length):
            if self.length(path) < longest and min(map(self.degree, (path[0], path[-1]))) > 2:
                self._drop(path)

    def _ties(self) -> list[list[int]]:
        """Ways from one junction to another."""
        if all(len(near) < 3 for near in self.links):
            return []
        return [path for path, closed in self.walks() if not closed and min(map(self.degree, (path[0], path[-1]))) > 2]

    def length(self, path: list[int]) -> float:
        """Length of the way along vertices [px]."""
        return float(np.linalg.norm(np.diff(self.points[path], axis=0), axis=1).sum())

    def _drop(self, path: list[int]) -> None:
        for a, b in pairwise(path):
            self.unlink(a, b)

    def walks(self) -> Iterable[tuple[list[int], bool]]:
        """Every edge once: paths between vertices that have not exactly two edges, then closed rounds.

        Yields
        ------
        vertices : list of int
            In order; the first is not repeated at the end of a round.
        closed : bool
            Whether the path is a round.
        """
        walked: set[tuple[int, int]] = set()

        def follow(start: int, towards: int) -> list[int]:
            path, before, vertex = [start], start, towards
            walked.add((min(start, towards), max(start, towards)))
            while True:
                path.append(vertex)
                if vertex == start or self.degree(vertex) != 2:
                    return path
                (ahead,) = self.links[vertex] - {before}
                walked.add((min(vertex, ahead), max(vertex, ahead)))
                before, vertex = vertex, ahead

        forks = [v for v in range(len(self.links)) if self.degree(v) not in (0, 2)]
        for vertices in (forks, range(len(self.links))):
            for v in vertices:
                for w in sorted(self.links[v]):
                    if (min(v, w), max(v, w)) not in walked:
                        path = follow(v, w)
                        closed = path[0] == path[-1]
                        yield (path[:-1] if closed else path), closed

    def contours(self) -> tuple[Contour, ...]:
        """Contours of the graph, longest first; a round through one junction counts as closed."""
        found = [
            Contour(
                self.points[path],
                closed,
                junctions=(False, False) if closed else (self.degree(path[0]) > 2, self.degree(path[-1]) > 2),
            )
            for path, closed in self.walks()
        ]
        return tuple(sorted(found, key=lambda contour: -contour.length))


def chains(points: Array, edges: Edges) -> tuple[Contour, ...]:
    """Contours along the edges of a graph.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Vertices.
    edges : ndarray of int64, shape (E, 2)
        Pairs of indices.

    Returns
    -------
    tuple of Contour
        Longest first.
    """
    return Graph(points, edges).contours()
