"""Subpixel refinement: from the position of a particle to the ridge of the edge."""

from __future__ import annotations

import numpy as np

from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Mask
from cpm_core.reconstruction.curve.ridge import (
    RIDGE_PROBE_DISTANCE,
    Ridge,
    interpolate_spline,
    ridge_arrays,
    uphill_direction,
)

MAX_RIDGE_DISTANCE = 2.5
"""Greatest distance of a particle from the ridge that it belongs to [px]."""

_MAX_REFINEMENTS = 8
"""Largest number of moves of a point."""

_MAX_REFINEMENT_MOVE = 0.4
"""Longest move of a point in one iteration [px]."""

_REFINEMENT_TOLERANCE = 1e-4
"""Move under which all points are final [px]."""

_NO_MOVE = 1e-12
"""Move under which a single point is final [px]."""

_MIN_POINTS_PER_THREAD = 500
"""Least number of points for a thread."""


def refine_to_ridge(positions: Array, scale_field: ScaleField) -> tuple[Array, Mask]:
    """Move points across the edge to the maximum of the edge map, interpolated by cubic splines.

    Each point is moved along the image gradient to the vertex of the parabola through three samples of the edge
    strength on its normal, until no point moves.

    Parameters
    ----------
    positions : ndarray, shape (N, 2)
        Points near edges [px].
    scale_field : ScaleField
        Fields of the scale.

    Returns
    -------
    refined : ndarray, shape (N, 2)
        Points on the ridge.
    found : ndarray of bool, shape (N,)
        Whether there was a ridge within `MAX_RIDGE_DISTANCE` of the point.
    """
    ridge = ridge_arrays(scale_field)
    place = np.array(positions, dtype=float)
    move, bend = np.full(len(place), np.inf), np.zeros(len(place))
    for _ in range(_MAX_REFINEMENTS):
        run_in_parallel(
            lambda first, last: _step_uphill(ridge, place, move, bend, first, last),
            len(place),
            _MIN_POINTS_PER_THREAD,
        )
        if np.abs(move).max(initial=0.0) < _REFINEMENT_TOLERANCE:
            break
    inside = ((place >= 0.0) & (place <= np.array(scale_field.shape) - 1.0)).all(axis=1)
    near = np.linalg.norm(place - positions, axis=1) < MAX_RIDGE_DISTANCE
    return place, inside & (bend < 0.0) & (np.abs(move) < 0.1) & near


@compiled
def _step_uphill(ridge: Ridge, place: Array, move: Array, bend: Array, first: int, last: int) -> None:
    """Move some points once, to the vertex of the parabola, or uphill where it has no maximum."""
    for i in range(first, last):
        if abs(move[i]) < _NO_MOVE:
            continue
        row, col = place[i, 0], place[i, 1]
        down, right = uphill_direction(ridge, row, col)
        behind = interpolate_spline(ridge.spline, row - RIDGE_PROBE_DISTANCE * down, col - RIDGE_PROBE_DISTANCE * right)
        middle = interpolate_spline(ridge.spline, row, col)
        ahead = interpolate_spline(ridge.spline, row + RIDGE_PROBE_DISTANCE * down, col + RIDGE_PROBE_DISTANCE * right)
        bend[i] = ahead - 2.0 * middle + behind
        rise = ahead - behind
        step = -0.5 * RIDGE_PROBE_DISTANCE * rise / bend[i] if bend[i] < 0.0 else np.sign(rise) * _MAX_REFINEMENT_MOVE
        move[i] = min(max(step, -_MAX_REFINEMENT_MOVE), _MAX_REFINEMENT_MOVE)
        place[i, 0] = row + move[i] * down
        place[i, 1] = col + move[i] * right
