"""How far the contours of two results lie apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from cpm_core.contours.result import Result
from cpm_core.numerics.types import Array

_SPACING = 0.5
"""Distance of the places on a contour at which it is measured [px]."""


@dataclass(frozen=True, slots=True)
class Difference:
    """Distances between two sets of contours.

    Attributes
    ----------
    mean, largest : float
        Mean of the distances from each to the nearest place of the other, both ways, and the largest of them (the
        Hausdorff distance) [px].
    """

    mean: float
    largest: float


def difference(one: Result, other: Result) -> Difference | None:
    """Distances between the contours of two results, None where one of them has no contours."""
    first, second = _places(one), _places(other)
    if not len(first) or not len(second):
        return None
    there, back = _nearest(first, second), _nearest(second, first)
    return Difference(0.5 * float(there.mean() + back.mean()), float(max(there.max(), back.max())))


def _nearest(places: Array, others: Array) -> Array:
    """Distance from each place to the nearest of the others."""
    return np.asarray(scipy.spatial.cKDTree(others).query(places)[0], dtype=float)


def _places(result: Result) -> Array:
    """Places along all contours, evenly spaced on each."""
    parts = [_along(contour.path) for contour in result.contours]
    return np.concatenate(parts) if parts else np.empty((0, 2))


def _along(path: Array) -> Array:
    run = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    at = np.linspace(0.0, run[-1], max(int(run[-1] / _SPACING), 1) + 1)
    return np.column_stack([np.interp(at, run, path[:, axis]) for axis in (0, 1)])
