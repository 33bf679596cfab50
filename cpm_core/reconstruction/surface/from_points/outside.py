"""The outside of a heap of triangles: what is left when loose ends are trimmed, and one walks around it."""

from __future__ import annotations

from collections import deque

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Index
from cpm_core.reconstruction.surface.from_points.normals import hollow

_SHARP = 1.5 * np.pi
"""Angle without any triangle around an edge from which on the edge is sharp: all its triangles are on one side."""

Side = tuple[int, bool]
"""A triangle, and whether it is seen from its back."""


def trimmed(points: Array, faces: Index) -> Index:
    """Triangles of which none has a sharp edge, after those that had one are removed, again and again."""
    while len(faces):
        ends = np.sort(faces[:, [[1, 2], [2, 0], [0, 1]]].reshape(-1, 2), axis=1)
        number = np.unique(ends[:, 0] * len(points) + ends[:, 1], return_inverse=True)[1]
        sharp = _widest_gaps(points, ends, number, faces.ravel())[number] > _SHARP
        if not sharp.any():
            break
        faces = faces[~sharp.reshape(-1, 3).any(1)]
    return faces


def _widest_gaps(points: Array, ends: Index, number: Index, opposite: Index) -> Array:
    """Largest angle between successive triangles around each edge."""
    axis = points[ends[:, 1]] - points[ends[:, 0]]
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    helper = np.eye(3)[np.abs(axis).argmin(1)]
    one = np.cross(axis, helper)
    toward = points[opposite] - points[ends[:, 0]]
    angle = np.arctan2((toward * np.cross(axis, one)).sum(1), (toward * one).sum(1))
    order = np.lexsort((angle, number))
    angle, group = angle[order], number[order]
    begins = np.flatnonzero(np.diff(group, prepend=-1))
    last = np.append(begins[1:], len(group)) - 1
    gaps = np.diff(angle, append=0.0)
    gaps[last] = angle[begins] + 2.0 * np.pi - angle[last]
    return np.maximum.reduceat(gaps, begins)


def extracted(points: Array, faces: Index) -> tuple[Array, Index]:
    """Vertices and triangles of the outside of a heap of triangles, part by part; hollows point inward.

    From each triangle one goes over an edge to the next that is met on the outside. Triangles that are seen from both
    sides belong to no inside and are left out.
    """
    if not len(faces):
        return np.empty((0, 3)), np.empty((0, 3), np.int64)
    rows, cols = faces[:, [0, 1]].ravel(), faces[:, [1, 2]].ravel()
    joined = scipy.sparse.coo_array((np.ones(len(rows), np.int8), (rows, cols)), shape=(len(points), len(points)))
    part = scipy.sparse.csgraph.connected_components(joined, directed=False)[1][faces[:, 0]]
    walk = _Walk(points, faces)
    for number in np.unique(part):
        walk.around(_outermost(points, faces, np.flatnonzero(part == number)))
    sides = [side for side in walk.pairs if (side[0], not side[1]) not in walk.pairs]
    oriented = np.array([walk.corners(side) for side in sides], np.int64).reshape(-1, 3)
    if not len(oriented):
        return np.empty((0, 3)), oriented
    centers = points[oriented].mean(1)
    normals = np.cross(points[oriented[:, 1]] - points[oriented[:, 0]], points[oriented[:, 2]] - points[oriented[:, 0]])
    number = np.unique(part[[side[0] for side in sides]], return_inverse=True)[1]
    inward = hollow(centers, normals, number)[number]
    vertices, split = _split(points, oriented, sides, walk.pairs)
    split[inward] = split[inward][:, ::-1]
    return vertices, split


def _outermost(points: Array, faces: Index, own: Index) -> Side:
    """A triangle of a part that can be seen from outside, as seen from there.

    It hangs on the edge that falls off least from the outermost point, and is the first that one meets around it.
    """
    first = int(faces[own].ravel()[points[faces[own], 0].argmax()])
    own = own[(faces[own] == first).any(1)]
    others = faces[own][faces[own] != first].reshape(-1, 2)
    ways = points[others] - points[first]
    ways /= np.linalg.norm(ways, axis=2, keepdims=True)
    row, col = np.unravel_index(ways[..., 0].argmax(), ways.shape[:2])
    axis, end = ways[row, col], others[row, col]
    hanging = own[(faces[own] == end).any(1)]
    third = [next(c for c in faces[k].tolist() if c not in (first, end)) for k in hanging]
    outward = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
    toward = points[third] - points[first]
    toward -= (toward @ axis)[:, None] * axis
    best = int(((toward @ outward) / np.maximum(np.linalg.norm(toward, axis=1), 1e-300)).argmax())
    a, b, c = points[faces[hanging[best]]]
    return int(hanging[best]), bool(np.cross(b - a, c - a) @ outward < 0.0)


class _Walk:
    """A walk over the outside of triangles, from each to its three neighbors."""

    def __init__(self, points: Array, faces: Index) -> None:
        self._points = points
        self._faces: list[list[int]] = faces.tolist()
        self._at_edge: dict[tuple[int, int], list[int]] = {}
        for number, (a, b, c) in enumerate(self._faces):
            for u, v in ((a, b), (b, c), (a, c)):
                self._at_edge.setdefault((u, v), []).append(number)
        self.pairs: dict[Side, list[Side]] = {}
        """The neighbors of each side that has been reached, over its edges in order."""

    def corners(self, side: Side) -> list[int]:
        """Corners of a triangle, counter-clockwise as seen from that side."""
        corners = self._faces[side[0]]
        return corners[::-1] if side[1] else corners

    def around(self, first: Side) -> None:
        """Reach all that can be reached from a side."""
        waiting = deque([first])
        while waiting:
            side = waiting.popleft()
            if side not in self.pairs:
                a, b, c = self.corners(side)
                self.pairs[side] = [self._next(side, *edge) for edge in ((a, b, c), (b, c, a), (c, a, b))]
                waiting.extend(self.pairs[side])

    def _next(self, side: Side, u: int, v: int, w: int) -> Side:
        """The side met over the edge from u to v of a triangle whose other corner is w; itself where there is none."""
        start, end = self._points[u], self._points[v]
        axis = (end - start) / np.linalg.norm(end - start)
        own = self._points[w] - start
        own = own - (own @ axis) * axis
        outward = np.cross(axis, own)
        best, least = side, np.inf
        for other in self._at_edge[min(u, v), max(u, v)]:
            if other != side[0]:
                third = next(corner for corner in self._faces[other] if corner not in (u, v))
                toward = self._points[third] - start
                angle = float(np.arctan2(toward @ outward, toward @ own)) % (2.0 * np.pi)
                if angle < least:
                    least, best = angle, (other, not self._runs(other, v, u))
        return best

    def _runs(self, face: int, u: int, v: int) -> bool:
        """Whether a triangle, seen from its front, runs from u to v."""
        a, b, c = self._faces[face]
        return (u, v) in ((a, b), (b, c), (c, a))


def _split(points: Array, oriented: Index, sides: list[Side], pairs: dict[Side, list[Side]]) -> tuple[Array, Index]:
    """Give a vertex of its own to each sheet that touches another one at a point."""
    place = {side: k for k, side in enumerate(sides)}
    one, other = [], []
    for k, side in enumerate(sides):
        for edge, neighbor in enumerate(pairs[side]):
            if neighbor in place:
                n = place[neighbor]
                for corner in (edge, (edge + 1) % 3):
                    one.append(3 * k + corner)
                    other.append(3 * n + oriented[n].tolist().index(oriented[k, corner]))
    count = 3 * len(sides)
    joined = scipy.sparse.coo_array((np.ones(len(one), np.int8), (one, other)), shape=(count, count))
    total, vertex = scipy.sparse.csgraph.connected_components(joined, directed=False)
    places = np.empty((total, 3))
    places[vertex] = points[oriented.ravel()]
    return places, vertex.reshape(-1, 3).astype(np.int64)
