"""Surfaces from points alone: where the height over the planes of the nearest points is zero.

The points are so dense on a grid of their own that neighbors are two voxels apart. Each gives the height over the
plane through it, weighted by a Gaussian of the distance (implicit moving least squares; Kolluri 2005, DOI
10.1145/1361192.1361195), and marching cubes follow the zero. Normals that are not given are estimated.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike

from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import label_joined_pairs, zero_surface
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.real_numbers import check_rows
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.reconstruction.surface.components import (
    fill_unknown_regions,
    has_point_within,
    set_border_voxels,
    typical_distance,
)

_STEPS_PER_POINT = 2.0
"""Steps of the grid between neighboring points."""

_HEIGHT_GAUSSIAN_WIDTH = 1.5
"""Width of the Gaussian that weights heights [steps of the grid]."""

_KNOWN_BAND = 3.5
"""Distance from a point up to which the height is known [steps of the grid]."""

_MAX_GRID_STEPS = 400_000_000
"""Largest number of steps of the grid: more need too much memory."""


def implicit_surface(points: Array, normals: Array, apart: float) -> tuple[Array, Index]:
    """Build a closed surface, vertices and triangles, through points, shape (N, 3), with unit normals outward.

    `apart` is the typical distance between the points, in their unit. ValueError when they are strewn so far apart
    that the grid would not fit into memory.
    """
    step = apart / _STEPS_PER_POINT
    begin = points.min(0) - step * (_KNOWN_BAND + 2.0)
    shape = np.ceil((points.max(0) - begin) / step + _KNOWN_BAND + 2.0)
    if not shape.prod() < _MAX_GRID_STEPS:
        raise ValueError(
            f"The points are {apart:g} apart, but spread over {np.ptp(points, axis=0).max():g}: a grid for them would "
            "not fit into memory. Leave out points far from the others, or give fewer."
        )
    height, weight = np.zeros((2, *shape.astype(int)), np.float32)
    _add_weighted_heights(height, weight, (points - begin) / step, normals)
    with np.errstate(invalid="ignore"):
        np.divide(height, weight, out=height)
    fill_unknown_regions(height)
    set_border_voxels(height, -1.0)
    vertices, faces = zero_surface(height)
    return vertices * step + begin, faces


@compiled
def _add_weighted_heights(height: Single, weight: Single, points: Array, normals: Array) -> None:
    """Add up the weighted heights below the planes of all points, and the weights."""
    reach = int(_KNOWN_BAND) + 1
    for i in range(len(points)):
        a, b, c = int(points[i, 0]), int(points[i, 1]), int(points[i, 2])
        for p in range(a - reach + 1, a + reach + 1):
            x = p - points[i, 0]
            for r in range(b - reach + 1, b + reach + 1):
                y = r - points[i, 1]
                for s in range(c - reach + 1, c + reach + 1):
                    z = s - points[i, 2]
                    off = x * x + y * y + z * z
                    if off <= _KNOWN_BAND * _KNOWN_BAND:
                        part = np.exp(-0.5 * off / _HEIGHT_GAUSSIAN_WIDTH**2)
                        height[p, r, s] -= part * (x * normals[i, 0] + y * normals[i, 1] + z * normals[i, 2])
                        weight[p, r, s] += part


_NORMAL_NEIGHBORS = 12
"""Number of neighbors that determine a normal: two rings around a point in a hexagonal pattern, less the farthest."""

_SIGN_LINKS = 10
"""Number of neighbors through which the sign of a normal spreads."""

_MAX_SIGN_LINK = 2.5
"""Largest distance over which the sign of a normal spreads [typical distances]."""

_MIN_LINK_COST = 1e-6
"""Least cost of a link: sparse graphs drop links of cost zero."""


def estimate_normals(points: Array, apart: float) -> Array:
    """Estimate unit normals of points, shape (N, 3), outward; `apart` is the typical distance between them.

    The normal is the direction in which the neighbors spread least. Its sign spreads from point to point along the
    links where normals agree best (Hoppe et al. 1992, DOI 10.1145/133994.134011). A part inside another surface, like
    the inner wall of a shell, is the surface of a hollow, and its normals point inward.
    """
    tree = scipy.spatial.KDTree(points)
    near = np.asarray(tree.query(points, min(_NORMAL_NEIGHBORS, len(points) - 1) + 1)[1])
    spread = points[near] - points[near].mean(1, keepdims=True)
    normals = np.linalg.eigh(np.einsum("nki,nkj->nij", spread, spread))[1][:, :, 0]
    distances, links = map(np.asarray, tree.query(points, min(_SIGN_LINKS, len(points) - 1) + 1))
    # the only indices of graphs that all releases of SciPy take
    one = np.repeat(np.arange(len(points), dtype=np.int32), links.shape[1])
    other = links.ravel().astype(np.int32)
    close = (distances.ravel() <= _MAX_SIGN_LINK * apart) & (one != other)
    one, other = one[close], other[close]
    price = 1.0 - np.abs((normals[one] * normals[other]).sum(1)) + _MIN_LINK_COST
    graph = scipy.sparse.csr_array((price, (one, other)), shape=(len(points), len(points)))
    part = label_joined_pairs((one, other), len(points))
    forest = scipy.sparse.csgraph.minimum_spanning_tree(graph)
    forest = forest + forest.T
    for number in range(part.max() + 1):
        members = np.flatnonzero(part == number)
        first = members[points[members, 0].argmax()]  # the outermost point, from which the sign spreads
        if normals[first, 0] < 0.0:
            normals[first] *= -1.0
        order, before = scipy.sparse.csgraph.breadth_first_order(forest, first, directed=False)
        for k in order[1:]:
            if normals[k] @ normals[before[k]] < 0.0:
                normals[k] *= -1.0
    normals[find_hollows(points, normals, part)[part]] *= -1.0
    return normals


def find_hollows(points: Array, normals: Array, part: Index) -> Mask:
    """Return whether parts, numbered by `part` (N,), lie inside an odd number of others; the arrays have N rows."""
    members = [np.flatnonzero(part == number) for number in range(int(part.max()) + 1)]
    within = np.zeros(len(members), int)
    for outer, around in enumerate(members):
        tree = scipy.spatial.KDTree(points[around])
        for inner, own in enumerate(members):
            if inner != outer:
                nearest = around[tree.query(points[own])[1]]
                inward = ((points[own] - points[nearest]) * normals[nearest]).sum(1) < 0.0
                within[inner] += bool(inward.mean() > 0.5)
    return within % 2 == 1


_MIN_SURFACE_POINTS = 4
"""Least number of points that span a surface."""

_MIN_POINTS_FOR_NORMALS = 13
"""Least number of points from which normals are estimated."""

_MIN_EXTENT = 1e-100
"""Least extent of the points: its cube is still a number."""

_MAX_EXTENT = 1e100
"""Largest extent of the points: its cube is still a number."""


def reconstruct_surface(points: ArrayLike, normals: ArrayLike | None = None) -> Surface:
    """Reconstruct a surface from points that lie densely on it, without the volume in which they were found.

    Parameters
    ----------
    points : array_like of real numbers, shape (N, 3)
        Places on the surface, in any unit, about equally far from their neighbors.
    normals : array_like of real numbers, shape (N, 3), optional
        Directions outward at the points, of any length. Without them they are estimated from the neighbors.

    Returns
    -------
    Surface
        Vertices are in the unit of the points.

    Raises
    ------
    ValueError
        When points or normals are not three finite real numbers each, when all points lie in a plane, or when they
        are too few.

    Notes
    -----
    Sheets, nested ones as well, have to be apart by more than about twice the distance between neighboring points, or
    they grow together. A sheet that ends in the open bounds nothing, and is closed by a guess.

    Examples
    --------
    >>> surface = cpm.reconstruct_surface(cpm.sphere((15, 15, 15), 9, 400))
    >>> surface.closed, surface.euler
    (True, 2)
    """
    places = check_rows("points", points, 3)
    places = np.unique(places, axis=0) if normals is None else places
    extent = float(np.abs(places - places[:1]).max()) if len(places) else 0.0
    if extent and not _MIN_EXTENT < extent < _MAX_EXTENT:
        raise ValueError(f"The points spread over {extent:g}: give them in another unit.")
    if (
        len(places) < _MIN_SURFACE_POINTS
        or not extent
        or np.linalg.matrix_rank((places - places.mean(0)) / extent, tol=1e-9) < 3
    ):
        raise ValueError(f"A surface needs points that span a volume, but these {len(places)} lie in a plane.")
    apart = typical_distance(places)
    if normals is not None:
        outward = check_rows("normals", normals, 3)
        if len(outward) != len(places):
            raise ValueError(f"There are {len(places)} points, but {len(outward)} normals: give one for each point.")
        lengths = np.linalg.norm(outward, axis=1)
        if not (lengths > 0.0).all():
            raise ValueError("A normal of length zero has no direction: leave its point out.")
        outward = outward / lengths[:, None]
    elif len(places) < _MIN_POINTS_FOR_NORMALS:
        raise ValueError(
            f"{len(places)} different points are too few to estimate normals: give {_MIN_POINTS_FOR_NORMALS} or "
            "more, or their normals."
        )
    else:
        outward = estimate_normals(places, apart)
    vertices, faces = implicit_surface(places, outward, apart)
    return Surface(vertices, faces, unsupported=1.0 - float(has_point_within(vertices, places, apart).mean()))
