"""Agreement of a surface with the ground truth of a volume.

Surfaces are compared as contours are in `cpm_core.contours.agreement`, by area in place of length: points are the
centers of triangles hardly longer than a voxel, and the distance of a point is that to the nearest triangle. Distances
are in the unit of the spacing. Along the border of the volume a surface is closed where no edge is; what lies beyond
the centers of the outermost voxels is not compared.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import scipy

from cpm_core.contours.agreement import TOLERANCE, Agreement, ObjectCounts, object_counts
from cpm_core.contours.ground_truth import VolumeTruth
from cpm_core.contours.surface import Surface, numbered
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.real_numbers import checked_number
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.parameters.quotation import described

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


@dataclass(frozen=True, eq=False)
class SurfaceComparison(Agreement):
    """Agreement of a surface with that of a ground truth, and of what they enclose.

    What `Agreement` says of the length of contours holds for the area of surfaces, and its distances are in the unit of
    the spacing. `mean_boundary_distance` is the average symmetric surface distance, `recall` and `precision` are the
    shares of the true and of the found area within the tolerance of the other surface (surface overlap; Nikolov et al.
    2021, doi:10.2196/26151, take both together).

    Attributes
    ----------
    dice, jaccard : float
        Overlap of the voxels inside, as for areas; NaN when the surface is not closed.
    objects : ObjectCounts
        How many objects have been found, missed and merged; all zero when the surface is not closed.
    wrong : ndarray, shape (N,)
        Distance of each vertex of the surface from the true one; 0 at the border of the volume.
    missing : ndarray, shape (M,)
        Distance of each vertex of `VolumeTruth.surface` from the found one; 0 at the border of the volume.
    unit : str or None
        Unit of the distances; None when it is not known.

    Examples
    --------
    >>> volume = cpm.example("ball")
    >>> found = cpm.segment(volume, cpm.sphere((15, 15, 15), 4, 60), cpm.PRESETS["volume"])
    >>> agreed = cpm.compare_surface(found.surface, cpm.VolumeTruth(found.labels))
    >>> agreed.dice, agreed.f, agreed.objects.found, agreed.mean_boundary_distance < 0.2
    (1.0, 1.0, 1, True)
    """

    dice: float
    jaccard: float
    objects: ObjectCounts
    wrong: Array = field(repr=False)
    missing: Array = field(repr=False)
    unit: str | None = None

    def __repr__(self) -> str:
        unit = self.unit or "voxels"
        return described(
            "SurfaceComparison", f"Dice {self.dice:.3f}", f"mean distance {self.mean_boundary_distance:.3g} {unit}",
            f"Hausdorff {self.hausdorff:.3g} {unit}", f"95 % {self.hausdorff95:.3g} {unit}",
        )  # fmt: skip


def compare_surface(surface: Surface | None, truth: VolumeTruth, tolerance: float | None = None) -> SurfaceComparison:
    """Compare a surface with the ground truth of its volume.

    Parameters
    ----------
    surface : Surface or None
        The surface of a result; None for none.
    truth : VolumeTruth
        Ground truth.
    tolerance : float, optional
        Distance up to which two surfaces count as the same, in the unit of the spacing; by default twice the smallest
        side of a voxel.

    Returns
    -------
    SurfaceComparison
        Overlap and distances.

    Raises
    ------
    ValueError
        When the tolerance is not a number above 0, or the surface and the truth have voxels of different sides.

    Examples
    --------
    >>> ball = np.linalg.norm(np.indices((31, 31, 31)) - 15.0, axis=0) <= 9.0
    >>> truth = cpm.VolumeTruth(ball, spacing=(0.5, 0.5, 0.5), unit="mm")
    >>> agreed = cpm.compare_surface(truth.surface, truth)
    >>> agreed.dice, agreed.hausdorff < 1e-6, agreed.unit
    (1.0, True, 'mm')
    """
    near, found = _checked(surface, truth, tolerance)
    shape, sides = truth.shape, np.array(truth.spacing)
    a, b = Triangles.of(found, shape), Triangles.of(truth.surface, shape)
    wrong, missing = (
        np.where(within_border(one.vertices, shape), other.distances(one.vertices * sides), 0.0)
        for one, other in ((found, b), (truth.surface, a))
    )
    there, back = b.distances(a.centers), a.distances(b.centers)
    tails = [_tail(away, some.areas) for away, some in ((there, a), (back, b)) if len(away)]
    whole = float(a.areas.sum() + b.areas.sum())
    mean = float(np.dot(there, a.areas) + np.dot(back, b.areas)) / whole if whole else 0.0
    corners = max(wrong.max(initial=0.0), missing.max(initial=0.0))
    dice, jaccard, objects = _overlap(found, truth)
    return SurfaceComparison(
        mean_boundary_distance=mean,
        hausdorff=float(max(there.max(initial=0.0), back.max(initial=0.0), corners)),
        hausdorff95=max(tails, default=0.0),
        recall=_share(back <= near, b.areas),
        precision=_share(there <= near, a.areas),
        tolerance=near,
        dice=dice,
        jaccard=jaccard,
        objects=objects,
        wrong=wrong,
        missing=missing,
        unit=truth.unit,
    )


def _checked(surface: Surface | None, truth: VolumeTruth, tolerance: float | None) -> tuple[float, Surface]:
    """The tolerance, and the surface, without triangles where there is none."""
    near = TOLERANCE * min(truth.spacing) if tolerance is None else tolerance
    checked_number("tolerance", near, lambda distance: distance > 0.0, "a distance above 0")
    found = Surface(np.empty((0, 3)), np.empty((0, 3), np.int64), truth.spacing) if surface is None else surface
    if not np.allclose(found.spacing, truth.spacing, rtol=1e-3):
        raise ValueError(
            f"the voxels of the surface are {_sides(found.spacing)} but those of {truth.source} "
            f"{_sides(truth.spacing)}: compare a surface with the ground truth of its own volume."
        )
    return near, found


def _overlap(found: Surface, truth: VolumeTruth) -> tuple[float, float, ObjectCounts]:
    """Dice and Jaccard of the voxels inside, and the counts of objects."""
    if len(found.faces) and not found.closed:
        return np.nan, np.nan, ObjectCounts(0, 0, 0, 0)
    numbers = numbered(found, truth.shape)
    height, width = int(truth.objects.max(initial=0)) + 1, int(numbers.max(initial=0)) + 1
    table = np.bincount((truth.objects.astype(np.int64) * width + numbers).ravel(), minlength=height * width)
    table = table.reshape(height, width)
    common, both = int(table[1:, 1:].sum()), int(table[1:].sum() + table[:, 1:].sum())
    dice = 2.0 * common / both if both else 1.0
    return dice, common / (both - common) if both else 1.0, object_counts(table)


def _tail(away: Array, weights: Array) -> float:
    """The distance that 95 % of an area stay within."""
    order = np.argsort(away)
    share = np.cumsum(weights[order])
    return float(away[order][min(int(np.searchsorted(share, 0.95 * share[-1])), len(away) - 1)])


def _share(near: Mask, weights: Array) -> float:
    """The part of an area; 1 of none."""
    return float(weights[near].sum() / weights.sum()) if len(weights) else 1.0


def _sides(spacing: tuple[float, ...]) -> str:
    return " x ".join(f"{side:g}" for side in spacing)
