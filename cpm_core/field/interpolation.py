"""Fields between the pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.kernels import compiled

Array = NDArray[np.float64]


def interpolate(field: Array, positions: Array) -> Array:
    r"""Multilinear interpolation of a field at positions between its nodes.

    Parameters
    ----------
    field : ndarray, shape (C, \*shape)
        Values on the pixels, `C` to each.
    positions : ndarray, shape (N, D)
        Where; positions beyond the outermost pixels feel the value of the nearest point of the border.

    Returns
    -------
    ndarray, shape (N, C)
        Interpolated values.
    """
    out = np.empty((len(positions), len(field)))
    shape = np.array(field.shape[1:], dtype=np.int64)
    _interpolate(flattened(field), shape, np.ascontiguousarray(positions, dtype=float), out)
    return out


def flattened(field: Array) -> Array:
    r"""Field of shape (C, \*shape) as the (C, M) array that the compiled loops read."""
    return np.ascontiguousarray(field, dtype=float).reshape(len(field), -1)


@compiled
def _corner(shape: NDArray[np.int64], point: Array, corner: int) -> tuple[int, float]:
    """Flat index and weight of one of the pixels around a point; the bits of `corner` say which."""
    weight, index = 1.0, 0
    for k in range(shape.size):
        x = min(max(point[k], 0.0), shape[k] - 1.0)
        low = min(np.int64(x), max(shape[k] - 2, 0))
        up = (corner >> k) & 1
        weight *= x - low if up else 1.0 - (x - low)
        index = index * shape[k] + min(low + up, shape[k] - 1)
    return index, weight


@compiled
def sample(flat: Array, shape: NDArray[np.int64], point: Array, out: Array) -> None:
    """Interpolate the field `flat`, shape (C, M), of an image of shape `shape` at one point into `out`, shape (C,)."""
    out[:] = 0.0
    for corner in range(1 << shape.size):
        index, weight = _corner(shape, point, corner)
        if weight != 0.0:
            for c in range(out.size):
                out[c] += weight * flat[c, index]


@compiled
def sample_one(values: Array, shape: NDArray[np.int64], point: Array) -> float:
    """Interpolate one flattened image, shape (M,), at one point."""
    total = 0.0
    for corner in range(1 << shape.size):
        index, weight = _corner(shape, point, corner)
        total += weight * values[index]
    return total


@compiled
def _interpolate(flat: Array, shape: NDArray[np.int64], positions: Array, out: Array) -> None:
    for i in range(len(positions)):
        sample(flat, shape, positions[i], out[i])
