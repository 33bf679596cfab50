"""Disks: the shape that a medial axis and its radii stand for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.polyline import lengths_along
from cpm_core.numerics.types import Array

_STRIDE = 0.25
"""Distance of the disks along an axis [px]: between two of radius 1.5 px, the rim dips by 0.005 px."""

_RIM = 0.005
"""Distance from a rim at which a pixel's centre lies on it [px], so that rounding decides nothing."""


def along(points: Array, radii: Array) -> Array:
    """Disks on a path, those between two vertices interpolated.

    Parameters
    ----------
    points : ndarray, shape (K, 2)
        Vertices [px].
    radii : ndarray, shape (K,)
        Radius at each [px].

    Returns
    -------
    ndarray, shape (M, 3)
        Row, column and radius of each disk [px].
    """
    way = lengths_along(points)
    at = np.union1d(way, np.arange(0.0, way[-1], _STRIDE))
    return np.column_stack([np.interp(at, way, values) for values in (*points.T, radii)])


def covered(disks: Array, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Pixels whose centres lie in a disk or on its rim.

    Every disk is a run of pixels in each of its rows, and every run a one where it begins and a minus one where it has
    ended; their sums along the rows are above zero where there is a disk. This is as many steps as the disks are high
    altogether, however much they overlap.

    Parameters
    ----------
    disks : ndarray, shape (M, 3)
        Row, column and radius of each [px].
    shape : tuple of int
        Shape of the image, (rows, columns).

    Returns
    -------
    ndarray of bool, shape `shape`
        Union of the disks.
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
