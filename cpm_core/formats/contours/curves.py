"""Curves of files, flattened to vertices that are nowhere farther than a fiftieth of a pixel from them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cpm_core.numerics.types import Array

CURVE_TOLERANCE = 0.005
"""Largest distance of a flattened curve from the curve itself [unit of the file; px in most]."""

_MAX_CURVE_VERTICES = 2000
"""Most vertices of one curve."""

_MIN_ELLIPSE_VERTICES = 128
"""Fewest vertices of an ellipse."""


def flatten_ellipse(
    center: Sequence[float] | Array,
    first: Sequence[float] | Array,
    second: Sequence[float] | Array,
) -> Array:
    """Flatten an ellipse.

    Parameters
    ----------
    center, first, second : sequence of float, shape (2,)
        Center, and two perpendicular half axes as vectors.

    Returns
    -------
    ndarray, shape (K, 2)
        Vertices, in order around the ellipse.
    """
    one, other = np.asarray(first, float), np.asarray(second, float)
    radius = max(float(np.linalg.norm(one)), float(np.linalg.norm(other)), CURVE_TOLERANCE)
    turn = 2.0 * math.acos(1.0 - min(CURVE_TOLERANCE / radius, 0.5))
    count = int(min(_MAX_CURVE_VERTICES, max(_MIN_ELLIPSE_VERTICES, 2.0 * math.pi / turn))) + 1
    angle = 2.0 * math.pi * np.arange(count) / count
    return np.asarray(center, float) + np.outer(np.cos(angle), one) + np.outer(np.sin(angle), other)


def rectangle_corners(corner: Sequence[float] | Array, opposite: Sequence[float] | Array) -> Array:
    """Return the corners of an upright rectangle with two given opposite ones, shape (4, 2)."""
    (top, left), (bottom, right) = corner, opposite
    return np.array([(top, left), (top, right), (bottom, right), (bottom, left)], float)


def flatten_bezier(*corners: Sequence[float] | Array) -> Array:
    """Flatten a quadratic or cubic Bézier curve with these control points, shape (2,); omits the first one."""
    control = np.array([tuple(corner) for corner in corners], float)
    if len(control) == 3:
        start, middle, end = control
        control = np.array([start, start + 2.0 / 3.0 * (middle - start), end + 2.0 / 3.0 * (middle - end), end])
    bend = 6.0 * np.linalg.norm(np.diff(control, 2, axis=0), axis=1).max()
    count = int(min(_MAX_CURVE_VERTICES, math.sqrt(bend / (8.0 * CURVE_TOLERANCE)))) + 1
    along = np.arange(1, count + 1) / count
    shares = np.stack([(1 - along) ** 3, 3 * (1 - along) ** 2 * along, 3 * (1 - along) * along**2, along**3], axis=1)
    return shares @ control
