"""Sub-pixel refinement: from where a particle rests to the crest of the edge."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.field.interpolation import interpolate
from cpm_core.level import Level

Array = NDArray[np.float64]

FARTHEST = 2.5
"""Distance from its place to the crest beyond which a particle is not taken to belong to it [px]."""

_PROBE = 0.3
_ITERATIONS = 8
_LONGEST_MOVE = 0.4
_DONE = 1e-4


def crest(positions: Array, level: Level) -> tuple[Array, NDArray[np.bool_]]:
    """Move points across the edge to the maximum of the cubic interpolated edge map.

    Each point is moved along the image gradient, by the vertex of the parabola through the edge strength at three
    places of its normal, until it moves no more.

    Parameters
    ----------
    positions : ndarray, shape (N, D)
        Points near edges [px].
    level : Level
        Fields of the scale.

    Returns
    -------
    refined : ndarray, shape (N, D)
        Points on the crest.
    found : ndarray of bool, shape (N,)
        Whether there was a crest within `FARTHEST` of the point.
    """
    spline = level.spline
    start = positions
    place = positions.copy()
    move = bend = np.zeros(len(place))
    for _ in range(_ITERATIONS):
        normal = interpolate(level.gradient, place)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]
        behind, middle, ahead = (_sample(spline, place + s * _PROBE * normal) for s in (-1.0, 0.0, 1.0))
        bend = ahead - 2.0 * middle + behind
        slope = ahead - behind
        with np.errstate(divide="ignore", invalid="ignore"):
            move = np.where(bend < 0.0, -0.5 * _PROBE * slope / bend, np.sign(slope) * _LONGEST_MOVE)
        move = np.clip(move, -_LONGEST_MOVE, _LONGEST_MOVE)
        place = place + move[:, None] * normal
        if np.abs(move).max(initial=0.0) < _DONE:
            break
    inside = ((place >= 0.0) & (place <= np.array(level.shape) - 1.0)).all(axis=1)
    found = inside & (bend < 0.0) & (np.abs(move) < 0.1) & (np.linalg.norm(place - start, axis=1) < FARTHEST)
    return place, found


def _sample(spline: Array, points: Array) -> Array:
    values: Array = scipy.ndimage.map_coordinates(spline, points.T, order=3, prefilter=False, mode="nearest")
    return values
