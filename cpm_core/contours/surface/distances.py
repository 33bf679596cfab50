"""Distances from points to the triangles of a surface, in units of length."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from cpm_core.contours.surface import Surface
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask

_CANDIDATES, _MOST_CANDIDATES = 12, 96
"""Triangles with the nearest centers that are tried for a point, and how many where these do not decide."""

_FINEST = 64
"""Parts that a side of a triangle is divided into at most."""


@dataclass(frozen=True, eq=False, slots=True)
class _Barycentric:
    """The equal triangles that a triangle is divided into: weights of its corners, shape (N, 3, 3)."""

    weights: Array

    @classmethod
    def of(cls, count: int) -> _Barycentric:
        """With so many parts of each side."""
        upright = [(i, j) for i in range(count) for j in range(count - i)]
        turned = [(i, j) for i, j in upright if i + j < count - 1]
        corners = [((i, j), (i + 1, j), (i, j + 1)) for i, j in upright]
        corners += [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i, j in turned]
        along = np.array(corners, dtype=float) / count
        return cls(np.concatenate([1.0 - along.sum(axis=2, keepdims=True), along], axis=2))


@dataclass(frozen=True, eq=False)
class Triangles:
    """Small triangles, whose centers stand for their area.

    Attributes
    ----------
    corners : ndarray, shape (N, 3, 3)
        Corners (plane, row, col) of each, in units of length.
    """

    corners: Array

    @classmethod
    def of(cls, surface: Surface, shape: tuple[int, ...]) -> Triangles:
        """Those of a surface, no longer than the smallest side of a voxel.

        Only those between the centers of the outermost voxels of a volume of this shape: along its border a surface is
        closed where no edge is.
        """
        sides = np.array(surface.spacing)
        corners = (surface.vertices * sides)[surface.faces]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0.0)
        parts = np.clip(np.ceil(longest / sides.min()), 1, _FINEST).astype(int)
        fine = [
            np.einsum("nkc,tcx->tnkx", _Barycentric.of(count).weights, corners[parts == count]).reshape(-1, 3, 3)
            for count in np.unique(parts).tolist()
        ]
        found = cls(np.concatenate([np.empty((0, 3, 3)), *fine]))
        return cls(found.corners[within_border(found.centers / sides, shape)])

    @cached_property
    def centers(self) -> Array:
        """Their centers of mass, shape (N, 3)."""
        return np.asarray(self.corners.mean(axis=1))

    @cached_property
    def areas(self) -> Array:
        """Their areas, shape (N,)."""
        a, b, c = (self.corners[:, corner] for corner in range(3))
        return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))

    @cached_property
    def _tree(self) -> scipy.spatial.cKDTree:
        return scipy.spatial.cKDTree(self.centers)

    @cached_property
    def _reach(self) -> float:
        """The farthest that a corner lies from the center of its triangle."""
        return float(np.linalg.norm(self.corners - self.centers[:, None], axis=2).max(initial=0.0))

    def distances(self, points: Array) -> Array:
        """Distance of each of points, shape (N, 3), from the nearest triangle; infinite where there is none."""
        found = np.full(len(points), np.inf)
        if not len(self.corners) or not len(points):
            return found
        count, open_ = min(_CANDIDATES, len(self.corners)), np.arange(len(points))
        while len(open_):
            away, near = self._tree.query(points[open_], k=np.arange(1, count + 1))
            tried = np.asarray(near, dtype=np.int64), np.asarray(away, dtype=np.float64)
            found[open_], certain = _nearest(points[open_], self.corners, *tried, self._reach)
            if count >= min(_MOST_CANDIDATES, len(self.corners)):
                break
            open_, count = open_[~certain], min(_MOST_CANDIDATES, len(self.corners))
        return found


def within_border(voxels: Array, shape: tuple[int, ...]) -> Mask:
    """Which of positions, shape (N, 3) [voxels], lie between the centers of the outermost voxels of a volume."""
    return np.asarray(((voxels >= 0.0) & (voxels <= np.array(shape) - 1.0)).all(axis=1))


@compiled
def _nearest(points: Array, corners: Array, near: Index, away: Array, reach: float) -> tuple[Array, Mask]:
    """Distance of points from the nearest of some triangles, and whether no other can be nearer.

    `near` are triangles in the order of the distance `away` of their centers; no corner is farther from its center
    than `reach`.
    """
    found = np.full(len(points), np.inf)
    certain = np.zeros(len(points), np.bool_)
    for n in range(len(points)):
        best = np.inf
        for k in range(near.shape[1]):
            if away[n, k] - reach >= best:
                certain[n] = True
                break
            best = min(best, _distance(points[n], corners[near[n, k]]))
        found[n] = best
    return found, certain


@compiled
def _distance(point: Array, corners: Array) -> float:
    """Distance of a point from a triangle."""
    a, b, c = corners[0], corners[1], corners[2]
    u, v, w = b - a, c - a, point - a
    uu, uv, vv, wu, wv = np.sum(u * u), np.sum(u * v), np.sum(v * v), np.sum(w * u), np.sum(w * v)
    whole = uu * vv - uv * uv
    if whole > 0.0:
        s, t = (vv * wu - uv * wv) / whole, (uu * wv - uv * wu) / whole
        if s >= 0.0 and t >= 0.0 and s + t <= 1.0:
            return float(np.sqrt(np.sum((w - s * u - t * v) ** 2)))
    return min(_from_side(point, a, b), _from_side(point, b, c), _from_side(point, c, a))


@compiled
def _from_side(point: Array, a: Array, b: Array) -> float:
    """Distance of a point from the line between two others."""
    along, from_a = b - a, point - a
    length = np.sum(along * along)
    share = min(max(np.sum(from_a * along) / length, 0.0), 1.0) if length > 0.0 else 0.0
    return float(np.sqrt(np.sum((from_a - share * along) ** 2)))
