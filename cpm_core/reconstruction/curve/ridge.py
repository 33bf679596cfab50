"""The edge map as a height field whose ridges are the edges: its value and slope at any position between pixels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.field.scale_field import SPLINE_MARGIN, ScaleField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array

RIDGE_PROBE_DISTANCE = 0.3
"""Distance on both sides of a position at which the edge map is sampled for its slope [px]."""


class Ridge(NamedTuple):
    """Arrays that define the ridges of a scale; a plain tuple for the compiled loops.

    Attributes
    ----------
    strength : ndarray, shape (H, W)
        Edge map.
    spline : ndarray, shape (H + 6, W + 6)
        Coefficients of its cubic spline, `ScaleField.spline`.
    down, right : ndarray, shape (H, W)
        Components of the image gradient.
    """

    strength: Array
    spline: Array
    down: Array
    right: Array


def ridge_arrays(scale_field: ScaleField) -> Ridge:
    """Collect the ridge arrays of a scale, without copies."""
    down, right = scale_field.gradient
    return Ridge(scale_field.edge_map, scale_field.spline, down, right)


@compiled
def interpolate_bilinear(values: Array, row: float, col: float) -> float:
    """Interpolate values of shape (H, W) bilinearly; positions beyond the image border are clamped to it."""
    rows, cols = values.shape
    row, col = min(max(row, 0.0), rows - 1.0), min(max(col, 0.0), cols - 1.0)
    above, before = int(row), int(col)
    s, t = row - above, col - before
    i, j = np.uintp(above), np.uintp(before)
    k, m = np.uintp(min(above + 1, rows - 1)), np.uintp(min(before + 1, cols - 1))
    upper, lower = (1.0 - t) * values[i, j] + t * values[i, m], (1.0 - t) * values[k, j] + t * values[k, m]
    return (1.0 - s) * upper + s * lower


@compiled
def uphill_direction(ridge: Ridge, row: float, col: float) -> tuple[float, float]:
    """Return the unit vector of the image gradient, which on an edge leads across it; zero without a gradient."""
    down, right = interpolate_bilinear(ridge.down, row, col), interpolate_bilinear(ridge.right, row, col)
    size = max(np.sqrt(down * down + right * right), 1e-300)
    return down / size, right / size


@compiled
def interpolate_spline(spline: Array, row: float, col: float) -> float:
    """Interpolate by the coefficients of a cubic spline, shape (H, W), with `SPLINE_MARGIN` on every side."""
    rows, cols = spline.shape
    row = min(max(row, -1.0), rows - 2.0 * SPLINE_MARGIN)
    col = min(max(col, -1.0), cols - 2.0 * SPLINE_MARGIN)
    above, before = int(row + 2.0), int(col + 2.0)
    down, right = _spline_weights(row + 2.0 - above), _spline_weights(col + 2.0 - before)
    total = 0.0
    for k in range(4):
        line = 0.0
        for m in range(4):
            line += right[m] * spline[np.uintp(above + k), np.uintp(before + m)]
        total += down[k] * line
    return total


@compiled
def _spline_weights(t: float) -> tuple[float, float, float, float]:
    """Compute the cubic B-spline weights of the four pixels around a position that is `t` beyond the second."""
    u = 1.0 - t
    return (
        u * u * u / 6.0,
        2.0 / 3.0 - t * t * (1.0 - 0.5 * t),
        2.0 / 3.0 - u * u * (1.0 - 0.5 * u),
        t * t * t / 6.0,
    )


@compiled
def slope_across_edge(ridge: Ridge, row: float, col: float) -> float:
    """Compute the difference of the edge map on both sides of a position, along the image gradient."""
    down, right = uphill_direction(ridge, row, col)
    ahead = interpolate_spline(ridge.spline, row + RIDGE_PROBE_DISTANCE * down, col + RIDGE_PROBE_DISTANCE * right)
    return ahead - interpolate_spline(
        ridge.spline, row - RIDGE_PROBE_DISTANCE * down, col - RIDGE_PROBE_DISTANCE * right
    )
