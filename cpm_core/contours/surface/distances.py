"""Distances from points to the triangles of a surface, in units of length."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from cpm_core.contours.surface import Surface
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask

_CANDIDATES = (3, 12, 48)
"""Triangles with the nearest centers that are tried for a point, and more of them where these do not decide."""

_FAR = 8.0
"""Distance beyond which the nearest centers decide, in largest distances of a corner from its center: the error is then
at most a sixteenth of that distance, less than a tenth of a voxel."""

_LONGEST = 1.5
"""Length of a side above which a triangle is divided, in smallest sides of a voxel; marching cubes make none above."""

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
        """Those of a surface, no longer than one and a half of the smallest side of a voxel.

        Only those between the centers of the outermost voxels of a volume of this shape: along its border a surface is
        closed where no edge is.
        """
        sides = np.array(surface.spacing)
        corners = (surface.vertices * sides)[surface.faces]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0.0)
        parts = np.clip(np.ceil(longest / (_LONGEST * sides.min())), 1, _FINEST).astype(int)
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
        left = np.arange(len(points))
        for most in _CANDIDATES:
            if not len(left):
                break
            count = min(most, len(self.corners))
            away, near = self._tree.query(points[left], k=np.arange(1, count + 1))
            tried = np.asarray(near, dtype=np.int64), np.asarray(away, dtype=np.float64)
            found[left], certain = _nearest(points[left], self.corners, *tried, self._reach)
            left = left[~certain & (found[left] < _FAR * self._reach)]
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
            if away[n, k] - reach >= np.sqrt(best):
                certain[n] = True
                break
            best = min(best, _squared(points, n, corners, near[n, k]))
        found[n] = np.sqrt(best)
    return found, certain


@compiled
def _squared(points: Array, n: int, corners: Array, t: int) -> float:
    """Squared distance of a point from a triangle; without arrays, which would take most of the time."""
    uu = uv = vv = wu = wv = ww = 0.0
    for axis in range(3):
        u, v = corners[t, 1, axis] - corners[t, 0, axis], corners[t, 2, axis] - corners[t, 0, axis]
        w = points[n, axis] - corners[t, 0, axis]
        uu, uv, vv, wu, wv, ww = uu + u * u, uv + u * v, vv + v * v, wu + w * u, wv + w * v, ww + w * w
    whole = uu * vv - uv * uv
    if whole > 0.0:
        a, b = (vv * wu - uv * wv) / whole, (uu * wv - uv * wu) / whole
        if a >= 0.0 and b >= 0.0 and a + b <= 1.0:
            return max(ww - 2.0 * (a * wu + b * wv) + a * a * uu + 2.0 * a * b * uv + b * b * vv, 0.0)
    return min(_from_side(points, n, corners, t, 0), _from_side(points, n, corners, t, 1),
               _from_side(points, n, corners, t, 2))  # fmt: skip


@compiled
def _from_side(points: Array, n: int, corners: Array, t: int, first: int) -> float:
    """Squared distance of a point from the side of a triangle that begins at a corner."""
    second = (first + 1) % 3
    length = along = away = 0.0
    for axis in range(3):
        side, w = corners[t, second, axis] - corners[t, first, axis], points[n, axis] - corners[t, first, axis]
        length, along, away = length + side * side, along + side * w, away + w * w
    share = min(max(along / length, 0.0), 1.0) if length > 0.0 else 0.0
    return max(away - 2.0 * share * along + share * share * length, 0.0)
