"""What the smoothing makes of steps in grey level, and how to take it back."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array

_WIDENED = 1.0 / 3.0 + 1.0 / 12.0
"""Variance that central differences, and the area of the pixels, add to that of the Gaussian [px²]."""

_FINEST, _ISOLATED = 0.05, 6.0
"""Half widths between which lines are corrected, in widths of the smoothed step: wider ones need no correction."""


def step_width(smoothing: float) -> float:
    """Width of a smoothed step: the standard deviation of its slope, with what pixels and differences add [px]."""
    return float(np.sqrt(smoothing**2 + _WIDENED))


def step_height(strength: Array, smoothing: float) -> Array:
    """Height of the step whose smoothed slope is so strong.

    Parameters
    ----------
    strength : ndarray
        Edge strength on the crest [grey levels / px].
    smoothing : float
        Sigma of the edge map [px].

    Returns
    -------
    ndarray
        Difference of the grey levels on both sides.
    """
    return np.asarray(strength * np.sqrt(2.0 * np.pi) * step_width(smoothing))


def half_width(distance: Array, smoothing: float) -> Array:
    """Half width of the line whose edges have their crests at this distance from its middle.

    The smoothing pushes the two edges of a thin line apart. With s the width of the smoothed step, the crest of the
    edge at h from the middle stands at d where ``(d - h) / (d + h) = exp(-2 d h / s²)``: for a line of 3 px and the
    usual smoothing of 1 px that is 0.12 px too far out, from 5 px on it is next to nothing.

    Parameters
    ----------
    distance : ndarray
        Distance of the middle to the crests [px].
    smoothing : float
        Sigma of the edge map [px].

    Returns
    -------
    ndarray
        Half width [px], at most `distance`.
    """
    half = np.geomspace(_FINEST, _ISOLATED, 400)
    low, high = half.copy(), half + 1.5
    for _ in range(40):  # the crest lies above the root of an increasing function
        middle = 0.5 * (low + high)
        beyond = (middle - half) > (middle + half) * np.exp(-2.0 * middle * half)
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    scale = step_width(smoothing)
    corrected = scale * np.interp(distance / scale, high, half)
    return np.where(distance < scale * high[-1], np.minimum(corrected, distance), distance)
