"""Region information: the gray levels on both sides of an edge.

The edge of an object divides two regions that differ; an edge of texture has the same mixture of dark and bright on
both sides.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from cpm_core.field.interpolation import interpolate_field
from cpm_core.numerics.types import Array, record

_HALF_DISK_RADIUS = 4.0
"""Constant part of the radius of the half disks that are compared [px]."""

_RADIUS_PER_SIGMA = 1.5
"""Part of that radius that grows with the smoothing [sigma]."""

_SAMPLE_RINGS = 4
"""Number of distances of sampling points in a half disk."""

_SAMPLE_SPOKES = 7
"""Number of directions of sampling points in a half disk."""


@record
class MeanContrast:
    """Measures the mean of `region_contrast` along a contour, which has the same arguments.

    Pickled it is the number, so that no contour takes its image along.
    """

    values: Array
    points: Array
    normals: Array
    smoothing: float

    def __call__(self) -> float:
        """Measure it."""
        return float(region_contrast(self.values, self.points, self.normals, self.smoothing).mean())

    def __reduce__(self) -> tuple[Callable[..., Any], tuple[object, ...]]:
        return partial, (float, self())


def region_contrast(values: Array, points: Array, normals: Array, smoothing: float) -> Array:
    """Return the contrast, shape (N,), of the regions on both sides of an edge at N points.

    In half disks on both sides, ``|m1 - m2| / (|m1 - m2| + s)`` with the means m1 and m2 and the root mean square s of
    the two standard deviations: from 0, where both sides have the same mean, to 1, where each is uniform and they
    differ. `values` is the image, shape (H, W), `points` and `normals`, shape (N, 2), are positions on edges [px] and
    the normals there, of any length, `smoothing` is the Gaussian with which the edges were found [px].
    """
    across = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    along = np.stack([-across[:, 1], across[:, 0]], axis=1)
    radius = _HALF_DISK_RADIUS + _RADIUS_PER_SIGMA * smoothing
    # equal areas, and no point on the edge itself
    distance = radius * np.sqrt((np.arange(_SAMPLE_RINGS) + 0.5) / _SAMPLE_RINGS)
    angle = np.pi * ((np.arange(_SAMPLE_SPOKES) + 0.5) / _SAMPLE_SPOKES - 0.5)
    ahead = np.outer(distance, np.cos(angle)).ravel()
    aside = np.outer(distance, np.sin(angle)).ravel()
    means, variances = [], []
    for sign in (-1.0, 1.0):
        places = points[:, None] + sign * ahead[:, None] * across[:, None] + aside[:, None] * along[:, None]
        seen = interpolate_field(values[None], places.reshape(-1, 2)).reshape(len(points), len(ahead))
        means.append(seen.mean(axis=1))
        variances.append(seen.var(axis=1))
    step = np.abs(means[1] - means[0])
    spread = np.sqrt(0.5 * (variances[0] + variances[1]))
    return step / np.maximum(step + spread, 1e-300)
