"""Differences of contours and surfaces from a ground truth, the worst first, and their cuts by a slice."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Literal

import numpy as np

from cpm_app.model.volume.slices import Slice
from cpm_app.model.volume.surface_section import cut_surface
from cpm_core import Comparison, Surface, SurfaceComparison, Truth, VolumeTruth
from cpm_core.contours import distances_to_contours
from cpm_core.contours.contour import Contours
from cpm_core.numerics import Array, Place, polyline
from cpm_core.numerics.polyline import step_lengths
from cpm_core.numerics.types import record

_PART_GAP = 0.6
"""Distance of neighboring points above which a new part begins [px]; along a boundary it is a quarter of a pixel."""


@record
class Difference:
    """A part of a boundary without a counterpart.

    Attributes
    ----------
    kind : {"missing", "wrong"}
        A part of the true boundary without a contour, or a part of a contour without a true boundary.
    points : ndarray, shape (K, 2)
        The part [px]; in a volume the corners of its triangles, shape (K, 3) [voxels].
    farthest : float
        Its largest distance [px]; in a volume in the unit of the spacing.
    place : tuple of float
        Position of that distance (row, col) [px], or (plane, row, col) [voxels].
    """

    kind: Literal["missing", "wrong"]
    points: Array
    farthest: float
    place: Place


def find_boundary_differences(contours: Contours, comparison: Comparison) -> tuple[Difference, ...]:
    """Return the parts of contours and ground truth farther apart than the tolerance, the farthest first."""
    found = []
    for contour, away in zip(contours, comparison.distances, strict=True):
        far = away > comparison.tolerance
        around = np.pad(far, 1, "wrap" if contour.closed else "constant")  # with the near neighbors of far vertices
        runs = polyline.find_marked_runs(around[:-2] | far | around[2:], contour.closed) if far.any() else []
        found += [_describe_part("wrong", contour.points[piece], away[piece]) for piece in runs]
    missing = comparison.missing
    if len(missing):
        away = distances_to_contours(missing, contours)
        cuts = np.flatnonzero(step_lengths(missing) > _PART_GAP) + 1
        pieces = zip(np.split(missing, cuts), np.split(away, cuts), strict=True)
        found += [_describe_part("missing", points, far) for points, far in pieces]
    return tuple(sorted(found, key=lambda difference: -difference.farthest))


def _describe_part(kind: Literal["missing", "wrong"], points: Array, away: Array) -> Difference:
    worst = away.argmax()
    return Difference(kind, points, float(away[worst]), tuple(points[worst].tolist()))


@record
class SurfaceDifference:
    """The triangles of a surface that are farther from another one than the tolerance.

    Attributes
    ----------
    kind : {"missing", "wrong"}
        Triangles of the true surface without a found one nearby, or of the found surface without a true one.
    surface : Surface
        The triangles.
    distances : ndarray, shape (N,)
        Distance of each of its vertices, in the unit of the spacing.
    """

    kind: Literal["missing", "wrong"]
    surface: Surface
    distances: Array

    @classmethod
    def from_distances(
        cls, kind: Literal["missing", "wrong"], whole: Surface, away: Array, tolerance: float
    ) -> SurfaceDifference:
        """Take the triangles with a corner farther away than the tolerance, ready for slices.

        Parameters
        ----------
        kind : {"missing", "wrong"}
            Kind of the difference.
        whole : Surface
            Surface with N vertices.
        away : ndarray, shape (N,)
            Distance of each vertex from the other surface, in the unit of the spacing.
        tolerance : float
            Largest distance that is no difference, in the same unit.
        """
        far = whole.faces[(away[whole.faces] > tolerance).any(axis=1)]
        used, faces = np.unique(far, return_inverse=True)
        surface = Surface(whole.vertices[used], faces.reshape(-1, 3), whole.spacing, whole.unit)
        return cls(kind, surface, away[used])

    @property
    def components(self) -> Iterator[Difference]:
        """Connected components of the triangles, each with its farthest place."""
        order = np.argsort(self.surface.component_of_vertex, kind="stable")
        ends = np.flatnonzero(np.diff(self.surface.component_of_vertex[order])) + 1
        for members in np.split(order, ends) if len(order) else []:
            yield _describe_part(self.kind, self.surface.vertices[members], self.distances[members])


def find_surface_differences(
    surface: Surface | None, truth: VolumeTruth, found: SurfaceComparison
) -> tuple[SurfaceDifference, ...]:
    """Return where a surface and the true one differ by more than the tolerance."""
    missing = SurfaceDifference.from_distances("missing", truth.surface, found.missing, found.tolerance)
    return (
        (missing,)
        if surface is None
        else (missing, SurfaceDifference.from_distances("wrong", surface, found.wrong, found.tolerance))
    )


def cut_truth(truth: Truth | VolumeTruth | None, here: Slice) -> Truth | None:
    """Cut the ground truth by a slice: return its boundaries there."""
    if not isinstance(truth, VolumeTruth):
        return truth
    return Truth(here.slice_array(truth.labels), cut_surface(truth.surface, here), truth.source)


def cut_differences(surface_differences: Iterable[SurfaceDifference], here: Slice) -> tuple[Difference, ...]:
    """Cut the surface differences by a slice; their distances are not shown there and are 0."""
    return tuple(
        Difference(each.kind, line.path, 0.0, (float(line.points[0, 0]), float(line.points[0, 1])))
        for each in surface_differences
        for line in cut_surface(each.surface, here)
    )
