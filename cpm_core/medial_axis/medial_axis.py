"""The medial axis: the edges of the Voronoi diagram of a boundary that do not cross the boundary; and its pruning.

It is the counterpart of the crust (`cpm_core.published.crust`): of each edge of the Delaunay triangulation
and its dual edge of the Voronoi diagram, either the first belongs to the curve or the second to its skeleton (Gold and
Snoeyink 2001, doi:10.1007/s00453-001-0014-x).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import field

import numpy as np
import scipy

from cpm_core.contours.graph import Graph
from cpm_core.medial_axis.boundary import Boundary
from cpm_core.numerics.grids import label_joined_pairs
from cpm_core.numerics.types import NO_POINTS, Array, Extent, Index, Mask, record

_BOUNDING_DISTANCE = 8.0
"""Distance, in sizes of the image, of the additional points that keep all Voronoi cells bounded."""

_AXIS_MARGIN = 0.5
"""Margin around the image in which the axis is kept, in sizes of the image."""

_MAX_AXIS_EDGE = 1.0
"""Greatest length of the edges of an axis [px]."""


@record
class MedialAxis:
    """A graph of positions with two or more nearest points on a boundary.

    Attributes
    ----------
    points : ndarray, shape (N, 2)
        Vertices [px].
    edges : ndarray of int64, shape (M, 2)
        Pairs of vertices.
    radius : ndarray, shape (N,)
        Distance of each vertex to the boundary [px].
    nearest : ndarray of int64, shape (N,)
        Point of the boundary at that distance.
    sides : ndarray of int64, shape (M, 2)
        The two points of the boundary that each edge lies between; without rows after pruning.
    """

    points: Array
    edges: Index
    radius: Array
    nearest: Index
    sides: Index = field(default_factory=lambda: np.zeros((0, 2), np.int64))

    def select_edges(self, edges: Mask) -> MedialAxis:
        """Select edges by a mask of shape (M,)."""
        return self.keep_edges(self.edges[edges], sides=self.sides[edges])

    def keep_edges(self, edges: Index, alone: Index | None = None, sides: Index | None = None) -> MedialAxis:
        """Keep some edges, shape (K, 2), the vertices that they join, and some isolated vertices, shape (L,)."""
        alone = np.zeros(0, np.int64) if alone is None else alone
        used, index = np.unique(np.concatenate([edges.ravel(), alone]), return_inverse=True)
        joined = index.ravel()[: edges.size].reshape(-1, 2)
        beside = np.zeros((0, 2), np.int64) if sides is None else sides
        return MedialAxis(self.points[used], joined, self.radius[used], self.nearest[used], beside)

    @property
    def middles(self) -> Array:
        """Middles of the edges, shape (M, 2) [px]."""
        return self.points[self.edges].mean(axis=1)

    @property
    def lengths(self) -> Array:
        """Lengths of the edges, shape (M,) [px]."""
        return np.linalg.norm(np.diff(self.points[self.edges], axis=1)[:, 0], axis=1)

    @property
    def widths(self) -> Array:
        """Mean diameters of the disks along the edges, shape (M,) [px]."""
        return 2.0 * self.radius[self.edges].mean(axis=1)

    @property
    def is_isolated(self) -> Mask:
        """Whether no edge joins a vertex, shape (N,)."""
        return np.bincount(self.edges.ravel(), minlength=len(self.points)) == 0

    def part_narrower_than(self, width: float) -> MedialAxis:
        """Return the part of the axis where disks are at most `width` across [px]."""
        thin = 2.0 * self.radius <= width
        return self.keep_edges(self.edges[thin[self.edges].all(axis=1)], np.flatnonzero(thin & self.is_isolated))

    def is_in_rectangle(self, low: Array | float, high: Array) -> Mask:
        """Return whether vertices lie in a rectangle, shape (N,)."""
        return np.all((self.points >= low) & (self.points <= high), axis=1)

    def clip_to_rectangle(self, low: Array, high: Array) -> MedialAxis:
        """Clip the axis, edges included, to a rectangle between two corners, shape (2,)."""
        places = np.column_stack([self.points, self.radius])
        nearest, edges, kept = self.nearest, self.edges.copy(), np.ones(len(self.edges), bool)
        for axis, bound, inward in [(k, end[k], sign) for end, sign in ((low, 1.0), (high, -1.0)) for k in range(2)]:
            height = inward * (places[:, axis] - bound)
            one, other = height[edges].T
            kept &= (np.maximum(one, other) > 0.0) | ((one == 0.0) & (other == 0.0))  # edges along a side are inside
            cut = np.flatnonzero(kept & (np.minimum(one, other) < 0.0))
            a, b = edges[cut].T
            share = one[cut] / (one[cut] - other[cut])
            between = places[a] + share[:, None] * (places[b] - places[a])
            between[:, axis] = bound
            edges[cut, np.where(one[cut] < 0.0, 0, 1)] = len(places) + np.arange(len(cut))
            places = np.concatenate([places, between])
            nearest = np.concatenate([nearest, nearest[np.where(share < 0.5, a, b)]])
        alone = np.flatnonzero(self.is_in_rectangle(low, high) & self.is_isolated)
        clipped = MedialAxis(places[:, :2], edges, places[:, 2], nearest)
        return clipped.keep_edges(edges[kept], alone, self.sides[kept] if len(self.sides) else None)


def compute_medial_axis(boundary: Boundary, shape: Extent) -> MedialAxis:
    """Compute the medial axis of all regions between edges, in objects and in the background.

    It covers the image of this shape and a margin around it. Edges are at most a pixel long, and every irregularity of
    the boundary has a short branch. The image border is no boundary.
    """
    size = np.array(shape, float)
    middle, widest = 0.5 * (size - 1.0), float(size.max())
    corners = middle + _BOUNDING_DISTANCE * widest * np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)])
    if len(boundary.points) < 2:
        return MedialAxis(NO_POINTS, np.zeros((0, 2), np.int64), np.zeros(0), np.zeros(0, np.int64))
    diagram = scipy.spatial.Voronoi(np.concatenate([boundary.points, corners]))
    count = len(boundary.points)
    sites = np.sort(diagram.ridge_points.astype(np.int64), axis=1)
    edges = np.asarray(diagram.ridge_vertices, np.int64)
    follow = np.sort(boundary.neighbors, axis=1)
    key = count + len(corners)
    crossing = np.isin(sites[:, 0] * key + sites[:, 1], follow[:, 0] * key + follow[:, 1])
    kept = ~crossing & (sites[:, 1] < count) & (edges >= 0).all(axis=1)
    tree = scipy.spatial.cKDTree(boundary.points)
    reach = 0.5 * size + _AXIS_MARGIN * widest
    whole = _axis_with_radii(diagram.vertices, edges[kept], sites[kept], tree)
    rough = whole.select_edges(np.ones(len(whole.edges), bool)).clip_to_rectangle(middle - reach, middle + reach)
    return _axis_with_radii(*_divide_long_edges(rough.points, rough.edges, rough.sides), tree)


def _axis_with_radii(points: Array, edges: Index, sides: Index, tree: scipy.spatial.cKDTree) -> MedialAxis:
    """Build an axis with the distances of its vertices from the boundary."""
    radius, nearest = tree.query(points)
    return MedialAxis(points, edges, np.asarray(radius), np.asarray(nearest, np.int64), sides)


def _divide_long_edges(points: Array, edges: Index, sides: Index) -> tuple[Array, Index, Index]:
    """Divide long edges, since the radius does not change linearly along them; return points, edges and their sides."""
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    pieces = np.maximum(np.ceil(np.linalg.norm(b - a, axis=1) / _MAX_AXIS_EDGE), 1).astype(np.int64)
    edge = np.repeat(np.arange(len(edges)), pieces - 1)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(pieces - 1) - (pieces - 1), pieces - 1) + 1
    between = a[edge] + (b - a)[edge] * (step / pieces[edge])[:, None]
    added = len(points) + np.arange(len(edge))
    first, last = step == 1, step == pieces[edge] - 1
    inner = np.stack([added[~last], added[~last] + 1], axis=1)
    starts = np.stack([edges[edge[first], 0], added[first]], axis=1)
    ends = np.stack([added[last], edges[edge[last], 1]], axis=1)
    parts = [sides[pieces == 1], sides[edge[first]], sides[edge[~last]], sides[edge[last]]]
    divided = np.concatenate([edges[pieces == 1], starts, inner, ends])
    return np.concatenate([points, between]), divided, np.concatenate(parts)


_MIN_BRANCH_LENGTH = 1.0
"""Least length of a branch, and of a path between two junctions [px]."""


def prune_axis(axis: MedialAxis, pruning: float) -> MedialAxis:
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
    count, part = label_axis_parts(axis)
    order = np.argsort(axis.radius, kind="stable")
    roots = np.zeros(count, np.int64)  # the vertex with the largest disk of each part
    roots[part[order]] = order  # the last value written is kept
    reach = axis.radius.copy()  # how far the shape removed behind a vertex reaches around it

    def is_covered(tip: int, following: int) -> bool:
        reached = np.linalg.norm(axis.points[tip] - axis.points[following]) + reach[tip]
        covered = bool(reached - axis.radius[following] <= pruning)
        if covered:
            reach[following] = max(reach[following], reached)
        return covered

    graph = Graph(axis.points, trim_tips(axis, is_covered, frozenset(roots.tolist())))
    graph.drop_spurs(_MIN_BRANCH_LENGTH)
    graph.merge_junctions(_MIN_BRANCH_LENGTH, axis.radius)
    edges = graph.edges()
    return axis.keep_edges(edges, roots[~np.isin(np.arange(count), part[edges[:, 0]])])


def label_axis_parts(axis: MedialAxis) -> tuple[int, Index]:
    """Label the connected parts of an axis; return their count and the part of each vertex, shape (N,)."""
    part = label_joined_pairs(axis.edges.T, len(axis.points))
    return int(part.max(initial=-1)) + 1, part


def trim_tips(axis: MedialAxis, should_remove: Callable[[int, int], bool], kept: frozenset[int] = frozenset()) -> Index:
    """Remove tips while `should_remove` of a tip and the vertex next to it; return the remaining edges, shape (K, 2).

    Vertices in `kept` are never removed.
    """
    links: list[set[int]] = [set() for _ in axis.points]
    for a, b in axis.edges.tolist():
        links[a].add(b)
        links[b].add(a)
    tips = [v for v, near in enumerate(links) if len(near) == 1 and v not in kept]
    while tips:
        tip = tips.pop()
        if not links[tip]:  # the other end of the same edge has left
            continue
        (following,) = links[tip]
        if should_remove(tip, following):
            links[tip].clear()
            links[following].discard(tip)
            if len(links[following]) == 1 and following not in kept:
                tips.append(following)
    return np.array([(v, w) for v, near in enumerate(links) for w in near if v < w], np.int64).reshape(-1, 2)
