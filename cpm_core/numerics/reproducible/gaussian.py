"""Gaussian filters: as those of `scipy.ndimage`, but with weights that have the same bits on every processor."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.types import Array

Mode = Literal["nearest", "reflect"]
"""How values go on beyond their ends: the last one again and again, or mirrored."""


def gaussian_filter(values: Array, sigma: float, truncate: float = 4.0, mode: Mode = "nearest") -> Array:
    r"""Values, shape (\*shape), smoothed along each axis; see `gaussian_filter1d`."""
    for axis in range(values.ndim):
        values = gaussian_filter1d(values, sigma, axis, truncate=truncate, mode=mode)
    return values


def gaussian_slope(values: Array, sigma: float, along: int) -> Array:
    r"""Derivative along one axis of the smoothed values, shape (\*shape)."""
    for axis in range(values.ndim):
        values = gaussian_filter1d(values, sigma, axis, order=int(axis == along))
    return values


def gaussian_gradient_magnitude(values: Array, sigma: float) -> Array:
    r"""Size of the gradient of the smoothed values, shape (\*shape)."""
    squares = (gaussian_slope(values, sigma, axis) ** 2 for axis in range(values.ndim))
    return np.asarray(np.sqrt(sum(squares)))


def gaussian_filter1d(
    values: NDArray[np.floating],
    sigma: float,
    axis: int,
    order: int = 0,
    truncate: float = 4.0,
    mode: Mode = "nearest",
    output: NDArray[np.floating] | None = None,
) -> NDArray[Any]:
    r"""Values smoothed along one axis.

    Parameters
    ----------
    values : ndarray of floats, shape (\*shape)
        What is smoothed.
    sigma : float
        Standard deviation [samples]; 0 leaves the values as they are.
    axis : int
        The axis.
    order : {0, 1}
        1 for the derivative of the smoothed values.
    truncate : float
        Where the weights end, in standard deviations.
    mode : {"nearest", "reflect"}
        How the values go on beyond their ends.
    output : ndarray, shape (\*shape), optional
        Array for the result.

    Returns
    -------
    ndarray, shape (\*shape)
        Of the type of the values, or `output`.
    """
    weights = _weights(float(sigma), order, int(truncate * sigma + 0.5))
    return np.asarray(scipy.ndimage.correlate1d(values, weights, axis, output, mode))


@lru_cache(maxsize=64)
def _weights(sigma: float, order: int, radius: int) -> tuple[float, ...]:
    """Weights of a Gaussian or of its derivative, by the exponential of the C library."""
    steps = range(-radius, radius + 1)
    bell = [math.exp(-0.5 * (step / sigma) * (step / sigma)) if step else 1.0 for step in steps]
    total = math.fsum(bell)
    slope = (step / (sigma * sigma) if order else 1.0 for step in steps)
    return tuple(each * weight / total for each, weight in zip(slope, bell, strict=True))
