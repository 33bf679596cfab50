"""The crust of points on a surface (Amenta, Bern and Kamvysselis 1998, DOI 10.1145/280814.280947).

Far Voronoi vertices of the points, their poles, lie near the medial axis and tell the normals. Triangles of the
Delaunay tetrahedra of points and poles that join three points are candidates; those across the normals are dropped
(normal filtering), those that end in the open are removed one after the other (trimming), and what can be reached
along the outside of the others is the surface (manifold extraction).
"""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Index
from cpm_core.reconstruction.surface.from_points.outside import extracted, trimmed

_SLANT = np.radians(60.0)
"""Largest angle between a triangle's normal and that of the corner with its largest angle."""

_SLANT_ELSEWHERE = 1.5 * _SLANT
"""The same at the other corners."""

_FAR = 3.0
"""Poles farther away than this, in sizes of the point set, are left out: they change nothing near the points."""

_SIDES: Index = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])


def crust(points: Array) -> tuple[Array, Index]:
    """Vertices and triangles of the crust of distinct points that span a volume, shape (N, 3).

    A vertex at which two sheets touch stands there twice.
    """
    poles, normals = _poles(points)
    candidates = _between_points(points, poles)
    faces = trimmed(points, _filtered(points, normals, candidates))
    return extracted(points, faces)


def _poles(points: Array) -> tuple[Array, Array]:
    """Poles of all points, shape (M, 3), and unit vectors toward the first of each: its normal, or against it."""
    cells = scipy.spatial.Delaunay(points)
    corners = cells.simplices.ravel()
    centers = np.repeat(_circumcenters(points[cells.simplices]), 4, axis=0)
    away = centers - points[corners]
    distance = np.linalg.norm(away, axis=1)
    first = np.zeros_like(points)
    order = np.argsort(distance, kind="stable")
    first[corners[order]] = away[order]  # the farthest is written last
    outward = _hull_normals(points, cells)
    on_hull = (outward != 0.0).any(1)
    direction = np.where(on_hull[:, None], outward, first)
    second = np.zeros_like(points)
    opposite = (away * direction[corners]).sum(1) < 0.0
    order = order[opposite[order]]
    second[corners[order]] = away[order]
    found = np.concatenate([(points + first)[~on_hull], (points + second)[(second != 0.0).any(1)]])
    reach = _FAR * np.ptp(points, axis=0).max()
    near = (np.abs(found - points.mean(0)) < reach).all(1)
    lengths = np.maximum(np.linalg.norm(direction, axis=1), 1e-300)
    return found[near], direction / lengths[:, None]


def _circumcenters(tetrahedra: Array) -> Array:
    """Centers of the spheres through the corners of tetrahedra, shape (K, 4, 3); far away where these are flat."""
    a, b, c, d = tetrahedra.transpose(1, 0, 2)
    b, c, d = b - a, c - a, d - a
    across = np.cross(c, d)
    volume = np.einsum("ij,ij->i", b, across)
    least = 1e-12 * np.abs(tetrahedra - a[:, None]).max((1, 2)) ** 3 + 1e-300
    volume = np.where(np.abs(volume) < least, least, volume)
    b2, c2, d2 = ((v * v).sum(1)[:, None] for v in (b, c, d))
    return np.asarray(a + (b2 * across + c2 * np.cross(d, b) + d2 * np.cross(b, c)) / (2.0 * volume[:, None]))


def _hull_normals(points: Array, cells: scipy.spatial.Delaunay) -> Array:
    """Mean outward normals of the convex hull at its points; zero at the others."""
    hull = cells.convex_hull
    normals = np.cross(points[hull[:, 1]] - points[hull[:, 0]], points[hull[:, 2]] - points[hull[:, 0]])
    inward = ((points[hull[:, 0]] - points.mean(0)) * normals).sum(1) < 0.0
    normals[inward] *= -1.0
    sums = np.zeros_like(points)
    for corner in range(3):
        np.add.at(sums, hull[:, corner], normals)
    return sums


def _between_points(points: Array, poles: Array) -> Index:
    """Triangles of the Delaunay tetrahedra of points and poles that join three points, each once, corners in order."""
    cells = scipy.spatial.Delaunay(np.concatenate([points, poles])).simplices
    faces = np.sort(cells[:, _SIDES].reshape(-1, 3), axis=1)
    return np.unique(faces[faces[:, 2] < len(points)], axis=0).astype(np.int64)


def _filtered(points: Array, normals: Array, faces: Index) -> Index:
    """Triangles that lie across the normals at their corners, up to the angles that are allowed."""
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-300)[:, None]
    slant = np.arccos(np.clip(np.abs((across[:, None] * normals[faces]).sum(2)), 0.0, 1.0))
    sides = np.linalg.norm(corners[:, [1, 2, 0]] - corners[:, [2, 0, 1]], axis=2)
    widest = sides.argmax(1)  # the largest angle lies opposite to the longest side
    allowed = np.where(np.arange(3) == widest[:, None], _SLANT, _SLANT_ELSEWHERE)
    return np.asarray(faces[(slant <= allowed).all(1)])
