"""Normals of points on surfaces: estimated from neighbors and turned outward."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Index, Mask

_NEIGHBORS = 12
"""Points that tell a normal: the two rings around a point in a hexagonal pattern, less the farthest."""

_LINKS, _FARTHEST = 10, 2.5
"""Neighbors through which the direction spreads, and their largest distance [typical distances]."""

_LEAST_PRICE = 1e-6
"""A price of zero would be no link."""


def estimated_normals(points: Array, apart: float) -> Array:
    """Unit normals of points, shape (N, 3), outward; `apart` is the typical distance between them.

    The normal is the direction in which the neighbors spread least. Its sign spreads from point to point along the
    links where normals agree best (Hoppe et al. 1992, DOI 10.1145/133994.134011). What lies inside another surface,
    like the inner wall of a shell, is the surface of a hollow, and points inward.
    """
    tree = scipy.spatial.KDTree(points)
    near = np.asarray(tree.query(points, min(_NEIGHBORS, len(points) - 1) + 1)[1])
    spread = points[near] - points[near].mean(1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("nki,nkj->nij", spread, spread))[1][:, :, 0]
    distances, links = map(np.asarray, tree.query(points, min(_LINKS, len(points) - 1) + 1))
    # the only indices of graphs that all releases of SciPy take
    one = np.repeat(np.arange(len(points), dtype=np.int32), links.shape[1])
    other = links.ravel().astype(np.int32)
    close = (distances.ravel() <= _FARTHEST * apart) & (one != other)
    one, other = one[close], other[close]
    price = 1.0 - np.abs((normals[one] * normals[other]).sum(1)) + _LEAST_PRICE
    graph = scipy.sparse.csr_array((price, (one, other)), shape=(len(points), len(points)))
    count, labels = scipy.sparse.csgraph.connected_components(graph, directed=False)
    part = labels.astype(np.int64)
    forest = scipy.sparse.csgraph.minimum_spanning_tree(graph)
    forest = forest + forest.T
    for number in range(count):
        _spread_sign(points, normals, forest, np.flatnonzero(part == number))
    normals[hollow(points, normals, part)[part]] *= -1.0
    return normals


def _spread_sign(points: Array, normals: Array, forest: scipy.sparse.csr_array, members: Index) -> None:
    """Turn the normals of a part outward, beginning with its outermost point."""
    first = members[points[members, 0].argmax()]
    if normals[first, 0] < 0.0:
        normals[first] *= -1.0
    order, before = scipy.sparse.csgraph.breadth_first_order(forest, first, directed=False)
    for k in order[1:]:
        if normals[k] @ normals[before[k]] < 0.0:
            normals[k] *= -1.0


def hollow(points: Array, normals: Array, part: Index) -> Mask:
    """Which parts, numbered from 0 up, lie inside an odd number of others; normals point out of each by itself."""
    members = [np.flatnonzero(part == number) for number in range(int(part.max()) + 1)]
    within = np.zeros(len(members), int)
    for outer, around in enumerate(members):
        tree = scipy.spatial.KDTree(points[around])
        for inner, own in enumerate(members):
            if inner != outer:
                nearest = around[tree.query(points[own])[1]]
                inward = ((points[own] - points[nearest]) * normals[nearest]).sum(1) < 0.0
                within[inner] += bool(inward.mean() > 0.5)
    return np.asarray(within % 2 == 1)
