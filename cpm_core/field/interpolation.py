"""Interpolation of fields between pixels: for any number of axes, and in the inner loops of a run."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled, inlined
from cpm_core.numerics.types import Array, Single
from cpm_core.numerics.vectors import Vector

# Numbers of NumPy's type: for each plain one Numba would compile the functions that take it once more.
FORCE_ROW = np.int64(0)
"""Component of a packed force field, shape (H, W, 5): Lorentz force along the rows."""

FORCE_COL = np.int64(1)
"""Component: Lorentz force along the columns."""

GRADIENT_ROW = np.int64(2)
"""Component: image gradient along the rows."""

GRADIENT_COL = np.int64(3)
"""Component: image gradient along the columns."""

EDGE_STRENGTH = np.int64(4)
"""Component: edge strength."""


def interpolate_field(field: NDArray[np.floating], positions: Array) -> Array:
    r"""Interpolate a field, shape (C, \*shape), linearly along each axis at positions, shape (N, D); shape (N, C).

    A position beyond the outermost pixels takes the value of the nearest point of the border.
    """
    parts = [scipy.ndimage.map_coordinates(part, positions.T, order=1, mode="nearest", output=float) for part in field]
    return np.stack(parts, axis=1)


@compiled
def pixel_before(packed: Single, y: float, x: float) -> tuple[int, int, float, float]:
    """Return the pixel before a position in an image, shape (H, W, ...), and the distance from it along each axis."""
    y = min(max(0.0, y), packed.shape[0] - 1.0)  # 0 first: that is the larger one when the other is no number
    x = min(max(0.0, x), packed.shape[1] - 1.0)
    row, col = min(int(y), packed.shape[0] - 2), min(int(x), packed.shape[1] - 2)
    return row, col, y - row, x - col


@compiled
def interpolate_component(packed: Single, c: np.int64, place: tuple[int, int, float, float]) -> float:
    """Interpolate component `c` of a packed force field, shape (H, W, C), at a position from `pixel_before`."""
    row, col, down, right = place
    upper = packed[row, col, c] * (1.0 - right) + packed[row, col + 1, c] * right
    lower = packed[row + 1, col, c] * (1.0 - right) + packed[row + 1, col + 1, c] * right
    return upper * (1.0 - down) + lower * down


@compiled
def voxel_before(count: int, at: float) -> tuple[int, float]:
    """Return the voxel before a position along an axis of `count` voxels, and the distance from it."""
    at = min(max(0.0, at), count - 1.0)  # 0 first: that is the larger one when the other is no number
    index = max(min(int(at), count - 2), 0)  # never negative, as the compiler sees too
    return index, at - index


@inlined
def trilinear_mean(volume: Single, plane: tuple[int, float], row: tuple[int, float], col: tuple[int, float]) -> float:
    """Interpolate a volume, shape (P, R, C), between eight voxels, by the first one and the distances from it."""
    i, z = plane
    j, y = row
    k, x = col
    a = volume[i, j, k] * (1.0 - x) + volume[i, j, k + 1] * x
    b = volume[i, j + 1, k] * (1.0 - x) + volume[i, j + 1, k + 1] * x
    c = volume[i + 1, j, k] * (1.0 - x) + volume[i + 1, j, k + 1] * x
    d = volume[i + 1, j + 1, k] * (1.0 - x) + volume[i + 1, j + 1, k + 1] * x
    return (a * (1.0 - y) + b * y) * (1.0 - z) + (c * (1.0 - y) + d * y) * z


@inlined
def value_at(volume: Single, plane: float, row: float, col: float) -> float:
    """Interpolate a volume, shape (P, R, C), at a position in voxels; beyond the outermost ones by their values."""
    planes, rows, cols = volume.shape
    return trilinear_mean(volume, voxel_before(planes, plane), voxel_before(rows, row), voxel_before(cols, col))


@compiled
def slope_at(volume: Single, pitch: Vector, place: Vector) -> Vector:
    """Return the slope of a volume, shape (P, R, C), at a place: differences over one unit to both sides."""
    planes, rows, cols = volume.shape
    z, y, x = place[0] / pitch[0], place[1] / pitch[1], place[2] / pitch[2]
    dz, dy, dx = 1.0 / pitch[0], 1.0 / pitch[1], 1.0 / pitch[2]
    plane, row, col = voxel_before(planes, z), voxel_before(rows, y), voxel_before(cols, x)
    above, below = voxel_before(planes, z - dz), voxel_before(planes, z + dz)
    before, behind = voxel_before(rows, y - dy), voxel_before(rows, y + dy)
    left, right = voxel_before(cols, x - dx), voxel_before(cols, x + dx)
    return (
        0.5 * (trilinear_mean(volume, below, row, col) - trilinear_mean(volume, above, row, col)),
        0.5 * (trilinear_mean(volume, plane, behind, col) - trilinear_mean(volume, plane, before, col)),
        0.5 * (trilinear_mean(volume, plane, row, right) - trilinear_mean(volume, plane, row, left)),
    )


@compiled
def normal_at(volume: Single, pitch: Vector, place: Vector) -> Vector:
    """Return the unit direction in which a volume, shape (P, R, C), rises most steeply; zero where it is flat."""
    z, y, x = slope_at(volume, pitch, place)
    size = np.sqrt(z * z + y * y + x * x) + 1e-12
    return z / size, y / size, x / size
