"""Comparison: how well contours agree with the ground truth, and where they do not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cpm_core.contours.contour import Contour
from cpm_core.contours.distances import distance_to, sampled
from cpm_core.contours.ground_truth import Truth, inside
from cpm_core.formats.masks.label_mask import paint
from cpm_core.numerics.types import Array, Mask

TOLERANCE = 2.0
"""Distance up to which two boundaries are taken for the same, unless told otherwise [px]."""


@dataclass(frozen=True, slots=True)
class Match:
    """An object of the ground truth, and the contour that covers it best.

    Attributes
    ----------
    label : int
        Label in `Truth.objects`.
    contour : int or None
        Index of the closed contour whose part of the label mask has the highest Dice coefficient with it; None when
        none covers any of it.
    dice : float
        That coefficient.
    """

    label: int
    contour: int | None
    dice: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """Agreement of contours with the ground truth.

    With A the pixels inside the contours and B those of objects, a the contours and b the true boundaries, d(x, c) the
    distance of a point to the nearest point of a curve, and averages over the length of curves:

    Attributes
    ----------
    dice : float
        2 |A ∩ B| / (|A| + |B|), Dice (1945), doi:10.2307/1932409. NaN when both are empty.
    jaccard : float
        |A ∩ B| / |A ∪ B|, Jaccard (1912). NaN when both are empty.
    hausdorff : float
        max(max_a d(x, b), max_b d(x, a)), Huttenlocher et al. (1993), doi:10.1109/34.232073 [px]. Distances are
        infinite when only one of the two has a boundary, NaN when none has.
    hausdorff95 : float
        The same with the 95th percentile in the place of each inner maximum, Taha and Hanbury (2015),
        doi:10.1186/s12880-015-0068-x [px].
    mean_boundary_distance : float
        Average of d(x, b) along a and of d(x, a) along b, over the length of both together: the average symmetric
        surface distance of Heimann et al. (2009), doi:10.1109/TMI.2009.2013851 [px].
    recall : float
        Share of the length of b within the tolerance of a, Martin et al. (2004), doi:10.1109/TPAMI.2004.1273918,
        without their matching one to one. NaN when there is no boundary.
    precision : float
        Share of the length of a within the tolerance of b. NaN when there is no contour.
    tolerance : float
        The tolerance [px].
    distances : tuple of ndarray, shape (K,)
        For each contour the distance from each of its vertices to b [px].
    missing : ndarray, shape (M, 2)
        Points every quarter of a pixel along b that lie farther than the tolerance from a [px].
    extra_area, missing_area : ndarray of bool, shape (H, W)
        A without B, and B without A.
    matches : tuple of Match
        One for each object.
    """

    dice: float
    jaccard: float
    hausdorff: float
    hausdorff95: float
    mean_boundary_distance: float
    recall: float
    precision: float
    tolerance: float
    distances: tuple[Array, ...]
    missing: Array
    extra_area: Mask
    missing_area: Mask
    matches: tuple[Match, ...]

    @property
    def f(self) -> float:
        """Harmonic mean of recall and precision; 0 when either is 0 or is not known."""
        both = self.recall + self.precision
        return 2.0 * self.recall * self.precision / both if both > 0.0 else 0.0


def compare(
    contours: Sequence[Contour], truth: Truth, tolerance: float = TOLERANCE, *, holes: bool = True
) -> Comparison:
    """Compare contours with the ground truth.

    Parameters
    ----------
    contours : sequence of Contour
        What was found, in px of the image. Open contours count for boundaries and enclose nothing.
    truth : Truth
        What is known.
    tolerance : float
        Distance up to which two boundaries are taken for the same [px].
    holes : bool
        Whether a contour in another is a hole of it, and one in that again an object. Otherwise all that lies inside of
        any closed contour is object, as it is where objects lie in objects.

    Returns
    -------
    Comparison
        Overlap, distances, and where they differ. Distances are to the lines themselves, from points every quarter of a
        pixel along them and from their vertices; pixels are inside when their centres are.

    Raises
    ------
    ValueError
        When the tolerance is no positive number.
    """
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise ValueError(f"tolerance is {tolerance:g} px but must be a number above 0.")
    found, true = inside(contours, truth.shape, holes=holes), truth.labels > 0
    common, either = int((found & true).sum()), int((found | true).sum())
    total = int(found.sum()) + int(true.sum())
    away, ends_away = _to(contours, truth.contours)
    missed, ends_missed = _to(truth.contours, contours)
    both = np.concatenate([away, missed])
    farthest = [np.concatenate(seen).max() for seen in ((away, ends_away), (missed, ends_missed)) if len(seen[0])]
    tails = [float(np.percentile(seen, 95.0, method="inverted_cdf")) for seen in (away, missed) if len(seen)]
    starts = np.cumsum([len(contour.points) for contour in contours])[:-1]
    return Comparison(
        dice=_ratio(2 * common, total),
        jaccard=_ratio(common, either),
        hausdorff=float(max(farthest, default=math.nan)),
        hausdorff95=max(tails, default=math.nan),
        mean_boundary_distance=float(both.mean()) if len(both) else math.nan,
        recall=_ratio(int((missed <= tolerance).sum()), len(missed)),
        precision=_ratio(int((away <= tolerance).sum()), len(away)),
        tolerance=tolerance,
        distances=tuple(np.split(ends_away, starts)) if contours else (),
        missing=truth.boundary[missed > tolerance],
        extra_area=found & ~true,
        missing_area=true & ~found,
        matches=_matches(contours, truth),
    )


def _to(contours: Sequence[Contour], others: Sequence[Contour]) -> tuple[Array, Array]:
    """Distances of points evenly along contours, and of their vertices, to the nearest of others."""
    none = np.empty((0, 2))
    samples = np.concatenate([none, *map(sampled, contours)])
    vertices = np.concatenate([none, *(contour.points for contour in contours)])
    distances = distance_to(np.concatenate([samples, vertices]), others)
    return distances[: len(samples)], distances[len(samples) :]


def _matches(contours: Sequence[Contour], truth: Truth) -> tuple[Match, ...]:
    """For each object the contour that covers it best."""
    objects = truth.objects.astype(np.int64)
    found = paint(contours, truth.shape).astype(np.int64)
    closed = [index for index, contour in enumerate(contours) if contour.closed]
    height, width = int(objects.max(initial=0)) + 1, len(closed) + 1
    table = np.bincount((objects * width + found).ravel(), minlength=height * width).reshape(height, width)
    sizes, areas = table.sum(axis=1), table.sum(axis=0)
    matches = []
    for label in np.flatnonzero(sizes[1:]) + 1:
        dice = 2.0 * table[label, 1:] / (sizes[label] + areas[1:])
        best = int(dice.argmax()) if closed else -1
        covered = best >= 0 and dice[best] > 0.0
        matches.append(Match(int(label), closed[best] if covered else None, float(dice[best]) if covered else 0.0))
    return tuple(matches)


def _ratio(part: int, whole: int) -> float:
    return part / whole if whole else math.nan
