"""Fields between the pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Single


def interpolate(field: NDArray[np.floating], positions: Array) -> Array:
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
    flat = np.ascontiguousarray(field, dtype=float).reshape(len(field), -1)
    _interpolate(flat, shape, np.ascontiguousarray(positions, dtype=float), out)
    return out


@compiled
def _interpolate(flat: Array, shape: NDArray[np.int64], positions: Array, out: Array) -> None:
    out[:] = 0.0
    for i in range(len(positions)):
        for corner in range(1 << shape.size):
            weight, index = 1.0, 0
            for k in range(shape.size):  # the bits of `corner` say which of the pixels around the place is meant
                x = min(max(positions[i, k], 0.0), shape[k] - 1.0)
                low = min(np.int64(x), max(shape[k] - 2, 0))
                up = (corner >> k) & 1
                weight *= x - low if up else 1.0 - (x - low)
                index = index * shape[k] + min(low + up, shape[k] - 1)
            if weight != 0.0:
                for c in range(len(flat)):
                    out[i, c] += weight * flat[c, index]


def interpolate_felt(packed: Single, positions: Array) -> Array:
    """Lorentz force at positions, shape (N, 2), by what is felt on the pixels, shape (H, W, C): its first components.

    As a step does it, and without a look at other pixels than those around the positions.
    """
    out = np.empty((len(positions), 2))
    _interpolate_felt(packed, np.ascontiguousarray(positions, dtype=float), out)
    return out


@compiled
def _interpolate_felt(packed: Single, positions: Array, out: Array) -> None:
    for i in range(len(positions)):
        place = between(packed, positions[i, 0], positions[i, 1])
        out[i, 0], out[i, 1] = component(packed, 0, place), component(packed, 1, place)


@compiled
def between(packed: Single, y: float, x: float) -> tuple[int, int, float, float]:
    """Pixel before a place in an image, shape (H, W, ...), and how far beyond it the place lies, along both axes."""
    y = min(max(y, 0.0), packed.shape[0] - 1.0)
    x = min(max(x, 0.0), packed.shape[1] - 1.0)
    row, col = min(int(y), packed.shape[0] - 2), min(int(x), packed.shape[1] - 2)
    return row, col, y - row, x - col


@compiled
def component(packed: Single, c: int, place: tuple[int, int, float, float]) -> float:
    """Component `c` of what is felt, shape (H, W, C), at a place as `between` tells it."""
    row, col, down, right = place
    upper = packed[row, col, c] * (1.0 - right) + packed[row, col + 1, c] * right
    lower = packed[row + 1, col, c] * (1.0 - right) + packed[row + 1, col + 1, c] * right
    value: float = upper * (1.0 - down) + lower * down
    return value
