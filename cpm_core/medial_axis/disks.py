"""Disks: the shape that a medial axis and its radii represent."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.polyline import lengths_along
from cpm_core.numerics.types import Array

_STRIDE = 0.25
"""Distance of the disks along an axis [px]: between two disks of radius 1.5 px the outline dips by 0.005 px."""

_RIM = 0.005
"""Tolerance of a disk's radius [px], so that rounding errors have no effect."""


def along(points: Array, radii: Array) -> Array:
    """Disks (row, col, radius), shape (M, 3), along a path, shape (K, 2), with interpolated radii, shape (K,) [px]."""
    way = lengths_along(points)
    at = np.union1d(way, np.arange(0.0, way[-1], _STRIDE))
    return np.column_stack([np.interp(at, way, values) for values in (*points.T, radii)])


def covered(disks: Array, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Pixels whose centers lie in one of the disks (row, col, radius), shape (M, 3) [px].

    Every disk is a run of pixels in each of its rows. A run adds one where it begins and subtracts one after its end;
    cumulative sums along the rows are above zero inside a disk. The cost is the sum of the disks' heights, however much
    they overlap.
    """
    rows, cols = shape
    row, col, radius = disks.T
    radius = radius + _RIM
    top = np.ceil(row - radius).clip(0, rows).astype(np.int64)
    bottom = np.floor(row + radius).clip(-1, rows - 1).astype(np.int64)
    height = (bottom - top + 1).clip(min=0)
    disk = np.repeat(np.arange(len(disks)), height)
    line = np.arange(len(disk)) - np.repeat(np.cumsum(height) - height, height) + top[disk]
    half = np.sqrt((radius[disk] ** 2 - (line - row[disk]) ** 2).clip(min=0.0))
    begin = np.ceil(col[disk] - half).clip(0, cols).astype(np.int64)
    end = np.floor(col[disk] + half).clip(-1, cols - 1).astype(np.int64) + 1
    some = begin < end
    first, last = (np.bincount((line * (cols + 1) + at)[some], minlength=rows * (cols + 1)) for at in (begin, end))
    return np.asarray(np.cumsum((first - last).reshape(rows, cols + 1), axis=1)[:, :-1] > 0)
