"""Where a surface and the ground truth of a volume differ, and what a slice shows of both."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from app.model.display.truth.differences import Difference
from app.model.volume.slices import Slice
from app.model.volume.surface_section import kept_with_surface, prepare, section
from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.surface import Surface
from cpm_core.contours.surface.agreement import SurfaceComparison
from cpm_core.contours.surface.ground_truth import VolumeTruth
from cpm_core.numerics.types import Array


@dataclass(frozen=True, eq=False, slots=True)
class Apart:
    """The triangles of a surface that are farther from another one than the tolerance.

    Attributes
    ----------
    kind : {"missing", "wrong"}
        Those of the true surface without a found one, or of the found surface without a true one.
    surface : Surface
        The triangles.
    away : ndarray, shape (N,)
        Distance of each of its vertices, in the unit of the spacing.
    """

    kind: Literal["missing", "wrong"]
    surface: Surface
    away: Array

    @classmethod
    def of(cls, kind: Literal["missing", "wrong"], whole: Surface, away: Array, tolerance: float) -> Apart:
        """Those with a corner farther away than the tolerance, ready for slices."""
        far = whole.faces[(away[whole.faces] > tolerance).any(axis=1)]
        used, faces = np.unique(far, return_inverse=True)
        surface = Surface(whole.vertices[used], faces.reshape(-1, 3), whole.spacing, whole.unit)
        prepare(surface)
        return cls(kind, surface, away[used])

    @property
    def parts(self) -> Iterator[Difference]:
        """Those that hang together, each with its farthest place."""
        order = np.argsort(self.surface.component_of_vertex, kind="stable")
        ends = np.flatnonzero(np.diff(self.surface.component_of_vertex[order])) + 1
        for members in np.split(order, ends) if len(order) else []:
            worst = members[int(self.away[members].argmax())]
            plane, row, col = self.surface.vertices[worst].tolist()
            places = self.surface.vertices[members]
            yield Difference(self.kind, places, float(self.away[worst]), (plane, row, col))


def apart_from(surface: Surface | None, truth: VolumeTruth, found: SurfaceComparison) -> tuple[Apart, ...]:
    """Where a surface and the true one are apart."""
    prepare(truth.surface)
    missing = Apart.of("missing", truth.surface, found.missing, found.tolerance)
    return (missing,) if surface is None else (missing, Apart.of("wrong", surface, found.wrong, found.tolerance))


def surface_differences(apart: Iterable[Apart]) -> tuple[Difference, ...]:
    """The parts of the surfaces one by one, the farthest first."""
    return tuple(sorted((part for each in apart for part in each.parts), key=lambda part: -part.farthest))


def truth_in(truth: Truth | VolumeTruth | None, here: Slice) -> Truth | None:
    """What a slice shows of the ground truth: its boundaries."""
    if not isinstance(truth, VolumeTruth):
        return truth
    return Truth(here.of(truth.labels), _lines(truth.surface, here), truth.source)


def differences_in(apart: Iterable[Apart], here: Slice) -> tuple[Difference, ...]:
    """What a slice shows of the parts that differ; how far they are apart is not told there."""
    return tuple(
        Difference(each.kind, line.path, 0.0, (float(line.points[0, 0]), float(line.points[0, 1])))
        for each in apart
        for line in _lines(each.surface, here)
    )


@kept_with_surface
def _lines(surface: Surface, here: Slice) -> tuple[Contour, ...]:
    return section(surface, here) if len(surface.faces) else ()
