"""Differences: parts of contours and of the ground truth that are far from each other, the worst first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from cpm_core.contours.agreement import Comparison, distance_to
from cpm_core.contours.contour import Contour
from cpm_core.contours.ground_truth import Truth
from cpm_core.numerics.types import Array, Place

_APART = 0.6
"""Distance of neighboring points above which a new part begins; along a boundary it is a quarter of a pixel [px]."""


@dataclass(frozen=True, eq=False, slots=True)
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


def differences(contours: Sequence[Contour], truth: Truth, comparison: Comparison) -> tuple[Difference, ...]:
    """The parts of contours and ground truth farther apart than the tolerance, the farthest first."""
    found = [
        _difference("wrong", contour.points[piece], away[piece])
        for contour, away in zip(contours, comparison.distances, strict=True)
        for piece in _stretches(away > comparison.tolerance, contour.closed)
    ]
    missing = comparison.missing
    if len(missing):
        away = distance_to(missing, contours)
        cuts = np.flatnonzero(np.linalg.norm(np.diff(missing, axis=0), axis=1) > _APART) + 1
        pieces = zip(np.split(missing, cuts), np.split(away, cuts), strict=True)
        found += [_difference("missing", points, far) for points, far in pieces]
    return tuple(sorted(found, key=lambda difference: -difference.farthest))


def _difference(kind: Literal["missing", "wrong"], points: Array, away: Array) -> Difference:
    worst = int(away.argmax())
    row, col = points[worst].tolist()
    return Difference(kind, points, float(away[worst]), (row, col))


def _stretches(far: NDArray[np.bool_], closed: bool) -> list[NDArray[np.intp]]:
    """Indices of consecutive far vertices, also around the end of a closed contour, with their near neighbors."""
    if not far.any():
        return []
    count = len(far)
    if far.all():
        return [np.r_[np.arange(count), 0] if closed else np.arange(count)]
    first = int(np.argmin(far)) if closed else 0  # a near vertex, so that no part goes around the end
    order = (first + np.arange(count)) % count
    runs = np.split(order, np.flatnonzero(np.diff(far[order])) + 1)
    wide = []
    for run in (run for run in runs if far[run[0]]):
        low, high = run[0] - 1, run[-1] + 1
        before = [low % count] if closed or low >= 0 else []
        behind = [high % count] if closed or high < count else []
        wide.append(np.array([*before, *run, *behind], dtype=np.intp))
    return wide
