"""Curve reconstruction: the crust of unorganized points (Amenta, Bern and Eppstein 1998, doi:10.1006/gmip.1998.0465).

The crust joins two points when some circle through both holds neither a point nor a vertex of the Voronoi diagram. It
can be computed from one Delaunay triangulation (Gold and Snoeyink 2001, doi:10.1007/s00453-001-0014-x): an edge
qualifies, locally, when the two angles opposite to it sum to at most a right angle.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour
from cpm_core.contours.graph import Graph
from cpm_core.numerics.polyline import pair_neighbors
from cpm_core.numerics.real_numbers import check_rows
from cpm_core.numerics.types import Array, Index

_MIN_TRIANGULATED_POINTS = 4
"""Least number of points that have a triangulation with a crust."""

_COTANGENT_OF_ZERO = 1e12
"""Cotangent used for an angle of 0."""


def find_crust_edges(points: Array) -> Index:
    """Find the edges of the one-step crust of distinct points, shape (N, 2): sorted pairs of indices, shape (E, 2)."""
    if len(points) < _MIN_TRIANGULATED_POINTS:
        return np.zeros((0, 2), np.int64)
    try:
        triangulation = scipy.spatial.Delaunay(points)
    except scipy.spatial.QhullError:  # all on one line: no triangles; the crust joins neighbors along it
        order = np.lexsort(points.T)
        return np.unique(np.sort(pair_neighbors(order), axis=1), axis=0)
    triangles, neighbors = triangulation.simplices.astype(np.int64), triangulation.neighbors
    cotangent = _corner_cotangents(points[triangles])
    number = np.arange(len(triangles))
    edges = []
    for k in range(3):  # the edge opposite to each corner, once for both of its triangles
        beyond = neighbors[:, k]
        one = np.flatnonzero((cotangent[:, k] > 0.0) & ((beyond < 0) | (number < beyond)))
        beyond = beyond[one]
        facing = np.argmax(neighbors[beyond] == one[:, None], axis=1)
        other = np.where(beyond < 0, _COTANGENT_OF_ZERO, cotangent[beyond, facing])  # beyond the hull: angle 0
        # the angles sum to at most a right angle: both acute, and the product of their cotangents at least one
        kept = one[(other > 0.0) & (cotangent[one, k] * other >= 1.0)]
        edges.append(np.sort(triangles[kept][:, [(k + 1) % 3, (k + 2) % 3]], axis=1))
    found = np.concatenate(edges)
    return found[np.lexsort((found[:, 1], found[:, 0]))]


def _corner_cotangents(triangles: Array) -> Array:
    """Compute the cotangents of the angles of triangles, shape (N, 3, 2), at their corners, shape (N, 3)."""
    out = np.empty(triangles.shape[:2])
    for k in range(3):
        u, v = triangles[:, (k + 1) % 3] - triangles[:, k], triangles[:, (k + 2) % 3] - triangles[:, k]
        cross = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
        out[:, k] = (u[:, 0] * v[:, 0] + u[:, 1] * v[:, 1]) / np.maximum(cross, 1e-300)
    return np.clip(out, -_COTANGENT_OF_ZERO, _COTANGENT_OF_ZERO)


def reconstruct_curve(points: ArrayLike) -> tuple[Contour, ...]:
    """Reconstruct contours through unorganized points: the paths of the crust.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        Points on curves, denser where curves bend or are near each other.

    Returns
    -------
    tuple of Contour
        Closed where the crust closes, else open, meeting in junctions where more than two edges meet; longest first.

    Raises
    ------
    ValueError
        For an array of another shape, or values that are not finite.

    Examples
    --------
    >>> contours = cpm.reconstruct_curve(cpm.circle((32, 32), 20))
    >>> len(contours), contours[0].closed, round(contours[0].area / (np.pi * 20**2), 2)
    (1, True, 1.0)
    """
    distinct = np.unique(check_rows("points", points, 2), axis=0)
    return Graph(distinct, find_crust_edges(distinct)).extract_contours()
