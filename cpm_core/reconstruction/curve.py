"""Curve reconstruction: the crust of unorganised points (Amenta, Bern and Eppstein 1998, doi:10.1006/gmip.1998.0465).

The crust joins two points when some circle through both holds neither a point nor a vertex of the Voronoi diagram. It
can be read off one Delaunay triangulation (Gold and Snoeyink 2001, doi:10.1007/s00453-001-0014-x): an edge qualifies,
locally, when the two angles opposite to it sum to at most a right angle.
"""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from cpm_core.contour import Contour
from cpm_core.reconstruction.graph import chains

Array = NDArray[np.float64]
Edges = NDArray[np.int64]

_LEAST_POINTS = 4

_FLATTEST = 1e12
"""Cotangent that stands for an angle of 0."""


def crust(points: Array) -> Edges:
    """Edges of the one-step crust.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Distinct points.

    Returns
    -------
    ndarray of int64, shape (E, 2)
        Pairs of indices, the lower one first, sorted.
    """
    if len(points) < _LEAST_POINTS:
        return np.zeros((0, 2), np.int64)
    try:
        triangles = scipy.spatial.Delaunay(points).simplices.astype(np.int64)
    except scipy.spatial.QhullError:  # all on one line: there is no triangle, and the crust joins neighbours along it
        order = np.lexsort(points.T)
        return np.unique(np.sort(np.stack([order[:-1], order[1:]], axis=1), axis=1), axis=0)
    # the edge opposite to each corner, and the cotangent of the angle there
    edges, cotangents = [], []
    for k in range(3):
        apex, a, b = (points[triangles[:, (k + s) % 3]] for s in range(3))
        u, v = a - apex, b - apex
        cross = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
        flat = np.einsum("ni,ni->n", u, v) / np.maximum(cross, 1e-300)
        cotangents.append(np.clip(flat, -_FLATTEST, _FLATTEST))
        edges.append(np.sort(triangles[:, [(k + 1) % 3, (k + 2) % 3]], axis=1))
    every, cotangent = np.concatenate(edges), np.concatenate(cotangents)
    key = every[:, 0] * len(points) + every[:, 1]
    order = np.argsort(key, kind="stable")
    key, every, cotangent = key[order], every[order], cotangent[order]
    first = np.flatnonzero(np.r_[True, key[1:] != key[:-1]])
    twice = np.append(first[1:], len(key)) - first == 2
    one = cotangent[first]
    other = np.where(twice, cotangent[np.minimum(first + 1, len(key) - 1)], _FLATTEST)  # beyond the hull: angle 0
    # the angles sum to at most a right angle: both acute, and the product of their cotangents at least one
    kept = (one > 0.0) & (other > 0.0) & (one * other >= 1.0)
    return every[first][kept]


def reconstruct_curve(points: ArrayLike) -> tuple[Contour, ...]:
    """Contours through unorganised points: the crust, walked from point to point.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        Points on curves, denser where the curves bend or come near each other.

    Returns
    -------
    tuple of Contour
        Closed where the crust closes, else open, meeting in junctions where more than two edges meet; longest first.

    Raises
    ------
    ValueError
        For an array of another shape, or values that are not finite.
    """
    array = np.asarray(points, dtype=float)
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"points have the shape {array.shape} but must be (N, 2).")
    if not np.isfinite(array).all():
        raise ValueError(
            f"points hold {int((~np.isfinite(array)).sum())} values that are not finite: leave those points out."
        )
    distinct = np.unique(array, axis=0)
    return chains(distinct, crust(distinct))
