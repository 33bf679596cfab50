"""Values of a volume between its voxels, for the inner loops of a run: no loop over axes.

Positions are lengths in units of the smallest side of a voxel; `pitch` has the sides of a voxel in these units.
"""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Single
from cpm_core.numerics.vectors import Vector


@compiled
def value_at(volume: Single, plane: float, row: float, col: float) -> float:
    """Trilinear interpolation at a position in voxels; beyond the outermost ones the value at the border."""
    z = min(max(0.0, plane), volume.shape[0] - 1.0)  # 0 first: that is the larger one when the other is no number
    y = min(max(0.0, row), volume.shape[1] - 1.0)
    x = min(max(0.0, col), volume.shape[2] - 1.0)
    i, j, k = min(int(z), volume.shape[0] - 2), min(int(y), volume.shape[1] - 2), min(int(x), volume.shape[2] - 2)
    z, y, x = z - i, y - j, x - k
    a = volume[i, j, k] * (1.0 - x) + volume[i, j, k + 1] * x
    b = volume[i, j + 1, k] * (1.0 - x) + volume[i, j + 1, k + 1] * x
    c = volume[i + 1, j, k] * (1.0 - x) + volume[i + 1, j, k + 1] * x
    d = volume[i + 1, j + 1, k] * (1.0 - x) + volume[i + 1, j + 1, k + 1] * x
    value: float = (a * (1.0 - y) + b * y) * (1.0 - z) + (c * (1.0 - y) + d * y) * z
    return value


@compiled
def sampled(volume: Single, pitch: Vector, place: Vector) -> float:
    """Value of a volume at a place."""
    return value_at(volume, place[0] / pitch[0], place[1] / pitch[1], place[2] / pitch[2])


@compiled
def slope_at(volume: Single, pitch: Vector, place: Vector) -> Vector:
    """Slope of a volume at a place: differences over one unit to both sides along each axis."""
    z, y, x = place[0] / pitch[0], place[1] / pitch[1], place[2] / pitch[2]
    dz, dy, dx = 1.0 / pitch[0], 1.0 / pitch[1], 1.0 / pitch[2]
    return (
        0.5 * (value_at(volume, z + dz, y, x) - value_at(volume, z - dz, y, x)),
        0.5 * (value_at(volume, z, y + dy, x) - value_at(volume, z, y - dy, x)),
        0.5 * (value_at(volume, z, y, x + dx) - value_at(volume, z, y, x - dx)),
    )


@compiled
def normal_at(volume: Single, pitch: Vector, place: Vector) -> Vector:
    """Direction in which a volume rises most steeply at a place; of no length where it is flat."""
    z, y, x = slope_at(volume, pitch, place)
    size = np.sqrt(z * z + y * y + x * x) + 1e-12
    return z / size, y / size, x / size


def normals_at(volume: Single, pitch: Vector, places: Array) -> Array:
    """Directions in which a volume rises most steeply at places, shape (N, 3)."""
    out = np.empty((len(places), 3))
    _normals_at(volume, pitch, np.ascontiguousarray(places, dtype=float), out)
    return out


@compiled
def _normals_at(volume: Single, pitch: Vector, places: Array, out: Array) -> None:
    for i in range(len(places)):
        normal = normal_at(volume, pitch, (places[i, 0], places[i, 1], places[i, 2]))
        out[i, 0], out[i, 1], out[i, 2] = normal[0], normal[1], normal[2]
