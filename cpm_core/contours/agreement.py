"""Agreement of contours with one another and with a ground truth.

Boundaries are compared by points every `SAMPLE_SPACING` along each and by the distance d(x, c) of a point x to the
nearest point on the lines c. Two empty sets agree perfectly: all fractions are 1 and all distances 0. An empty and a
nonempty set are infinitely far apart and have no common area; the fraction of the empty boundary is 1, since none of it
is wrong, and the fraction of the other is 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.contour import Contours, sample_contours, stack_vertices
from cpm_core.contours.ground_truth import Truth
from cpm_core.contours.rasterize import rasterize_labels, rasterize_mask
from cpm_core.numerics.real_numbers import check_finite_number
from cpm_core.numerics.segments import SegmentTree
from cpm_core.numerics.types import NO_POINTS, Array, Arrays, Index, Mask, frozen, record
from cpm_core.parameters.formatting import format_repr

DEFAULT_TOLERANCE = 2.0
"""Default distance up to which two boundaries count as the same [px]."""


@frozen
class ObjectCounts:
    """Counts of objects; one is found by a closed contour if their Jaccard index is above 1/2.

    Attributes
    ----------
    found, missed : int
        True objects with and without such a contour.
    extra : int
        Closed contours that find no object.
    merged : int
        Extra contours that contain more than half of each of two or more objects.
    """

    found: int
    missed: int
    extra: int
    merged: int

    @property
    def average_precision(self) -> float:
        """Found objects as a fraction of all that are found, missed or extra (AP at 0.5); 1 if there are none."""
        count = self.found + self.missed + self.extra
        return self.found / count if count else 1.0


@record
class Agreement:
    """Agreement of the boundaries a with the boundaries b.

    Averages and fractions are taken over the length of curves.

    Attributes
    ----------
    mean_boundary_distance : float
        Average of d(x, b) along a and of d(x, a) along b, over the total length: the average symmetric
        surface distance of Heimann et al. (2009), doi:10.1109/TMI.2009.2013851 [px].
    hausdorff : float
        max(max_a d(x, b), max_b d(x, a)), Huttenlocher et al. (1993), doi:10.1109/34.232073 [px].
    hausdorff95 : float
        Like `hausdorff`, with the 95th percentile in place of each inner maximum, Taha and Hanbury (2015),
        doi:10.1186/s12880-015-0068-x [px].
    recall : float
        Fraction of the length of b within the tolerance of a, Martin et al. (2004), doi:10.1109/TPAMI.2004.1273918,
        without one-to-one matching; 1 when b is empty.
    precision : float
        Fraction of the length of a within the tolerance of b; 1 when a is empty.
    tolerance : float
        The tolerance [px].
    """

    mean_boundary_distance: float
    hausdorff: float
    hausdorff95: float
    recall: float
    precision: float
    tolerance: float

    @property
    def f(self) -> float:
        """Harmonic mean of recall and precision; 0 when either is 0."""
        both = self.recall + self.precision
        return 2.0 * self.recall * self.precision / both if both > 0.0 else 0.0


@record
class Comparison(Agreement):
    """Agreement of contours, a, with the boundaries b of a ground truth, and of the enclosed areas.

    A are the pixels inside the contours, B the pixels of objects; boundaries are as in `Agreement`.

    Attributes
    ----------
    dice : float
        ``2 |A ∩ B| / (|A| + |B|)``, Dice (1945), doi:10.2307/1932409; 1 when both are empty.
    jaccard : float
        ``|A ∩ B| / |A ∪ B|``, Jaccard (1912); 1 when both are empty.
    distances : tuple of ndarray, shape (K,)
        For each contour the distance from each of its vertices to b [px].
    missing : ndarray, shape (M, 2)
        Points every quarter of a pixel along b that are farther from a than the tolerance [px].
    objects : ObjectCounts
        How many objects have been found, missed and merged.

    Examples
    --------
    >>> truth = cpm.segment(cpm.example("disks"), cpm.uniform_grid((64, 64)))
    >>> found = cpm.segment(cpm.example("disks"), cpm.circle((32, 18), 4))
    >>> agreed = cpm.compare(found.contours, cpm.Truth(truth.labels, truth.contours))
    >>> round(agreed.f, 2), round(agreed.dice, 2), agreed.objects.found, agreed.hausdorff < 0.1
    (1.0, 1.0, 2, True)
    """

    dice: float
    jaccard: float
    distances: Arrays
    missing: Array
    objects: ObjectCounts

    def __repr__(self) -> str:
        return format_repr(
            "Comparison",
            f"F {self.f:.3f} within {self.tolerance:g} px",
            f"mean distance {self.mean_boundary_distance:.3g} px",
            f"Dice {self.dice:.3f}",
            f"{self.objects.found} of {self.objects.found + self.objects.missed} objects found",
        )


def compare_boundaries(contours: Contours, others: Contours, tolerance: float = DEFAULT_TOLERANCE) -> Agreement:
    """Compare the boundaries of contours with those of others.

    Parameters
    ----------
    contours, others : sequence of Contour
        Both sets of contours [px].
    tolerance : float
        Distance up to which two boundaries count as the same [px].

    Returns
    -------
    Agreement
        Distances and fractions.

    Raises
    ------
    ValueError
        When the tolerance is not a positive number.
    """
    _check_tolerance(tolerance)
    return Agreement(**_measure_agreement(_SampledBoundary(contours), _SampledBoundary(others), tolerance))


def compare(
    contours: Contours, truth: Truth, tolerance: float = DEFAULT_TOLERANCE, *, holes: bool = True
) -> Comparison:
    """Compare contours with the ground truth.

    Parameters
    ----------
    contours : sequence of Contour
        Contours in px of the image. Open contours are boundaries but enclose nothing.
    truth : Truth
        Ground truth.
    tolerance : float
        Distance up to which two boundaries count as the same [px].
    holes : bool
        Whether a contour inside another is a hole, and a contour inside a hole another object. Otherwise
        everything inside a closed contour is object.

    Returns
    -------
    Comparison
        Overlap, distances and differences; a pixel is inside when its center is. A stretch along the border of the
        image is boundary of neither where an object of the truth reaches the border: it cannot be seen there.

    Raises
    ------
    ValueError
        When the tolerance is not a positive number.

    Examples
    --------
    >>> result = cpm.segment(cpm.example("disk"), cpm.circle((32, 32), 8))
    >>> inside = np.hypot(*(np.indices((64, 64)) - 32)) <= 20
    >>> truth = cpm.Truth(inside.astype(np.int32), (cpm.Contour(cpm.circle((32, 32), 20), True),))
    >>> found = cpm.compare(result.contours, truth)
    >>> found.dice > 0.99, found.f, found.objects.found
    (True, 1.0, 1)
    """
    _check_tolerance(tolerance)
    a, b = (_SampledBoundary(some, truth, tolerance) for some in (contours, truth.contours))
    found, true = rasterize_mask(contours, truth.shape, holes=holes), truth.labels > 0
    dice, jaccard = dice_and_jaccard(int((found & true).sum()), int(found.sum() + true.sum()))
    starts = np.cumsum([len(contour.points) for contour in contours])[:-1]
    return Comparison(
        **_measure_agreement(a, b, tolerance),
        dice=dice,
        jaccard=jaccard,
        distances=tuple(np.split(b.tree.distances_to(stack_vertices(contours)), starts)) if contours else (),
        missing=b.samples[a.tree.distances_to(b.samples) > tolerance],
        objects=count_objects(count_common_pixels(truth.objects, rasterize_labels(contours, truth.shape))),
    )


def distances_to_contours(points: Array, contours: Contours) -> Array:
    """Measure the distance of points, shape (N, 2), from the nearest line of contours, shape (N,) [px]; inf if none."""
    return _SampledBoundary(contours).tree.distances_to(np.asarray(points, float))


class _SampledBoundary:
    """Samples and segments of contours; of a truth without the samples where its objects reach the image border."""

    def __init__(self, contours: Contours, truth: Truth | None = None, tolerance: float = 0.0) -> None:
        paths = [contour.path for contour in contours]
        self.samples, self.vertices = sample_contours(contours), stack_vertices(contours)
        if truth is not None:
            self.samples, self.vertices = (
                kept[~_is_cut_by_border(kept, truth, tolerance)] for kept in (self.samples, self.vertices)
            )
        begin = np.concatenate([NO_POINTS, *(path[:-1] for path in paths)])
        self.tree = SegmentTree(begin, np.concatenate([NO_POINTS, *(path[1:] for path in paths)]))


def _is_cut_by_border(points: Array, truth: Truth, tolerance: float) -> Mask:
    """Return whether points, shape (N, 2), lie near the image border where it cuts an object, shape (N,)."""
    last = np.array(truth.shape) - 1
    before, beyond = points + 0.5 <= tolerance, last + 0.5 - points <= tolerance
    pixels = np.where(before, 0, np.where(beyond, last, np.clip(np.rint(points), 0, last))).astype(int)
    return np.any(before | beyond, axis=1) & (truth.labels[tuple(pixels.T)] > 0)


def _measure_agreement(a: _SampledBoundary, b: _SampledBoundary, tolerance: float) -> dict[str, float]:
    """Compute the attributes of `Agreement`."""
    there, back = b.tree.distances_to(a.samples), a.tree.distances_to(b.samples)
    corners = max(b.tree.distances_to(a.vertices).max(initial=0.0), a.tree.distances_to(b.vertices).max(initial=0.0))
    return summarize_distances((there, np.ones(len(there))), (back, np.ones(len(back))), float(corners), tolerance)


def summarize_distances(
    there: tuple[Array, Array], back: tuple[Array, Array], corners: float, tolerance: float
) -> dict[str, float]:
    """Compute the attributes of `Agreement` from distances and the sizes of the parts they belong to.

    Parameters
    ----------
    there, back : tuple of two ndarray, shape (N,)
        Distances of parts of a from b, and of parts of b from a, each with the sizes of the parts.
    corners : float
        Greatest distance of a corner of one from the other.
    tolerance : float
        Distance up to which boundaries coincide.
    """
    precision, recall = (
        float(size[away <= tolerance].sum() / size.sum()) if len(away) else 1.0 for away, size in (there, back)
    )
    both = [(away, size) for away, size in (there, back) if len(away)]
    tails = [float(np.percentile(away, 95.0, weights=size, method="inverted_cdf")) for away, size in both]
    whole = sum(float(size.sum()) for _, size in both)
    return {
        "mean_boundary_distance": sum(float(away @ size) for away, size in both) / whole if whole else 0.0,
        "hausdorff": max([corners, *(float(away.max()) for away, _ in both)]),
        "hausdorff95": max(tails, default=0.0),
        "recall": recall,
        "precision": precision,
        "tolerance": tolerance,
    }


def _check_tolerance(tolerance: float) -> None:
    check_finite_number("tolerance", tolerance, lambda distance: distance > 0.0, "a number of px above 0")


def dice_and_jaccard(common: int, both: int) -> tuple[float, float]:
    """Return the Dice and Jaccard coefficients of two masks, from their common pixels and the sum of their pixels."""
    return (2.0 * common / both, common / (both - common)) if both else (1.0, 1.0)


def count_common_pixels(true: NDArray[np.integer], found: NDArray[np.integer]) -> Index:
    """Count the pixels that each true object has in common with each found one.

    Parameters
    ----------
    true, found : ndarray of int, shape (H, W) or (P, R, C)
        Label of each pixel, 0 for the background.

    Returns
    -------
    ndarray of int64, shape (T + 1, F + 1)
        Counts by true label (rows) and found label (columns); the first of each is the background.
    """
    height, width = int(true.max(initial=0)) + 1, int(found.max(initial=0)) + 1
    pairs = true.astype(np.int64) * width + found
    return np.bincount(pairs.ravel(), minlength=height * width).reshape(height, width)


def count_objects(table: Index) -> ObjectCounts:
    """Count objects from the pixels that each true one (rows) has in each found one (columns), shape (T + 1, F + 1).

    The first row and the first column are the background.
    """
    sizes, areas, common = table.sum(axis=1)[1:], table.sum(axis=0)[1:], table[1:, 1:]
    either = sizes[:, None] + areas[None, :] - common
    found = int((2 * common > either).sum())  # above 1/2 there is at most one contour for an object, and one for it
    merged = int(((2 * common > sizes[:, None]).sum(axis=0) > 1).sum())
    return ObjectCounts(found, int((sizes > 0).sum()) - found, int((areas > 0).sum()) - found, merged)
