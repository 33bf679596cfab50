"""Agreement of a surface with the ground truth of a volume.

Surfaces are compared like contours in `cpm_core.contours.agreement`, by area in place of length: the points
are the centers of triangles hardly longer than a voxel, and their distance is measured to the nearest triangle.
Distances are in the unit of the spacing. Along the border of the volume a surface is closed where no edge is; anything
beyond the centers of the outermost voxels is not compared.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy

from cpm_core.contours.agreement import (
    DEFAULT_TOLERANCE,
    Agreement,
    ObjectCounts,
    count_common_pixels,
    count_objects,
    dice_and_jaccard,
    summarize_distances,
)
from cpm_core.contours.ground_truth import VolumeTruth
from cpm_core.contours.surface import label_voxels
from cpm_core.image.surface import Surface
from cpm_core.numerics.real_numbers import check_finite_number
from cpm_core.numerics.types import Array, Extent, Mask, record
from cpm_core.parameters.formatting import format_repr

_CANDIDATE_TRIANGLES = 16
"""Number of triangles, by nearest centers, that are tried for each point."""

_POINTS_PER_BATCH = 20_000
"""Number of points whose distances are computed at once, to bound the memory."""

_MAX_TRIANGLE_SIDE = 1.5
"""Side above which a triangle is divided [smallest sides of a voxel]; marching cubes make no longer ones."""

_MAX_TRIANGLE_HALVINGS = 6
"""Largest number of times that the sides of a triangle are halved."""


@record
class TriangleSamples:
    """Small triangles, whose centers stand for their area.

    Attributes
    ----------
    corners : ndarray, shape (N, 3, 3)
        Corners (plane, row, col) of each, in units of length.
    """

    corners: Array

    @cached_property
    def centers(self) -> Array:
        """Centers of mass of the triangles, shape (N, 3)."""
        return self.corners.mean(axis=1)

    @cached_property
    def areas(self) -> Array:
        """Areas of the triangles, shape (N,)."""
        a, b, c = (self.corners[:, corner] for corner in range(3))
        return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)

    @cached_property
    def _tree(self) -> scipy.spatial.cKDTree:
        return scipy.spatial.cKDTree(self.centers)

    def distances_to(self, points: Array) -> Array:
        """Measure the distance of points, shape (N, 3), from the nearest triangle, shape (N,); infinite without any."""
        found = np.full(len(points), np.inf)
        if not len(self.corners):
            return found
        count = min(_CANDIDATE_TRIANGLES, len(self.corners))
        for first in range(0, len(points), _POINTS_PER_BATCH):
            some = slice(first, first + _POINTS_PER_BATCH)
            near = np.asarray(self._tree.query(points[some], k=np.arange(1, count + 1))[1], np.int64)
            # from the nearest place of each triangle: over its inside, or on its rim
            corners = self.corners[near]
            offset, side = points[some, None, None, :] - corners, np.roll(corners, -1, axis=2) - corners
            square = np.maximum((side**2).sum(axis=-1), 1e-300)
            share = np.clip((offset * side).sum(axis=-1) / square, 0.0, 1.0)
            away = np.linalg.norm(offset - share[..., None] * side, axis=-1).min(axis=-1)
            normal = np.cross(side[:, :, 0], side[:, :, 1])
            size = np.maximum(np.linalg.norm(normal, axis=-1), 1e-300)
            above = (np.cross(side, offset) * normal[:, :, None]).sum(axis=-1)
            within = (above >= 0.0).all(axis=-1) & (size > 1e-300)
            height = np.abs((offset[:, :, 0] * normal).sum(axis=-1)) / size
            found[some] = np.where(within, height, away).min(axis=1)
        return found


def sample_triangles(surface: Surface, shape: Extent) -> TriangleSamples:
    """Divide a surface into triangles no longer than one and a half of the smallest side of a voxel.

    Only triangles between the centers of the outermost voxels of a volume of this shape are kept: along its border a
    surface is closed where no edge is.
    """
    sides = np.array(surface.spacing)
    corners = (surface.vertices * sides)[surface.faces]
    for _ in range(_MAX_TRIANGLE_HALVINGS):
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1, initial=0.0)
        large = longest > _MAX_TRIANGLE_SIDE * sides.min()
        a, b, c = corners[large].swapaxes(0, 1)
        halves = 0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)
        four = (a, halves[0], halves[2]), (halves[0], b, halves[1]), (halves[2], halves[1], c), halves
        corners = np.concatenate([corners[~large], *(np.stack(some, axis=1) for some in four)])
    return TriangleSamples(corners[is_within_border(corners.mean(axis=1) / sides, shape)])


def is_within_border(voxels: Array, shape: Extent) -> Mask:
    """Return whether positions, shape (N, 3) [voxels], lie between the centers of the outermost voxels, shape (N,)."""
    return np.all((voxels >= 0.0) & (voxels <= np.array(shape) - 1.0), axis=1)


@record
class SurfaceComparison(Agreement):
    """Agreement of a surface with a true one, and of the volumes that they enclose.

    The measures are those of `Agreement`, by the area of surfaces in place of the length of contours, in the unit of
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
    wrong: Array
    missing: Array
    unit: str | None = None

    def __repr__(self) -> str:
        unit = self.unit or "voxels"
        return format_repr(
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
    near = DEFAULT_TOLERANCE * min(truth.spacing) if tolerance is None else tolerance
    check_finite_number("tolerance", near, lambda distance: distance > 0.0, "a distance above 0")
    found = Surface(np.empty(0), np.empty(0, np.int64), truth.spacing) if surface is None else surface
    if not np.allclose(found.spacing, truth.spacing, rtol=1e-3):
        one, other = (" x ".join(f"{side:g}" for side in sides) for sides in (found.spacing, truth.spacing))
        raise ValueError(
            f"the voxels of the surface are {one} but those of {truth.source} {other}: compare a surface with the "
            "ground truth of its own volume."
        )
    shape, sides = truth.shape, np.array(truth.spacing)
    a, b = sample_triangles(found, shape), sample_triangles(truth.surface, shape)
    wrong, missing = (
        np.where(is_within_border(one.vertices, shape), other.distances_to(one.vertices * sides), 0.0)
        for one, other in ((found, b), (truth.surface, a))
    )
    dice, jaccard, objects = np.nan, np.nan, ObjectCounts(0, 0, 0, 0)
    if found.closed or not len(found.faces):
        table = count_common_pixels(truth.objects, label_voxels(found, shape))
        dice, jaccard = dice_and_jaccard(int(table[1:, 1:].sum()), int(table[1:].sum() + table[:, 1:].sum()))
        objects = count_objects(table)
    return SurfaceComparison(
        **summarize_distances(
            (b.distances_to(a.centers), a.areas),
            (a.distances_to(b.centers), b.areas),
            float(max(wrong.max(initial=0.0), missing.max(initial=0.0))),
            near,
        ),
        dice=dice,
        jaccard=jaccard,
        objects=objects,
        wrong=wrong,
        missing=missing,
        unit=truth.unit,
    )
