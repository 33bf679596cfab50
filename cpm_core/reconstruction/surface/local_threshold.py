"""Height of gray levels over the local threshold of the edge: positive on its bright side, zero on the surface.

At each particle the smoothed volume has some value, the local threshold of the edge. Around the particles it is
spread by a Gaussian, and the surface lies where the volume passes through it. So it follows edges whose contrast and
gray levels change from place to place, as no single threshold does.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.types import Array, Index, Single, record

_MIN_PLANES_PER_THREAD = 4
"""Least number of planes for a thread."""

_GAUSSIAN_CUTOFF = 3.0
"""Widths of the Gaussian beyond which a particle has no influence."""

_MIN_BAND_RADIUS = 2.0
"""Least half thickness of the band around the particles [voxels]: it holds voxels on both sides of every edge."""


@record
class LocalThresholds:
    """Particles on the edges of a volume, shape (N, 3) [voxels], with the local threshold and the slope of the edge.

    The threshold is the gray level of the smoothed volume at which the edge lies, the slope is the steepness of the
    edge [gray levels / smallest side of a voxel].
    """

    points: Array
    thresholds: Array
    slopes: Array


class VoxelBox(NamedTuple):
    """A part of a volume: its first voxel, shape (3,), and the number of voxels along each axis."""

    begin: Index
    shape: tuple[int, int, int]


def height_over_threshold(
    volume: Single, box: VoxelBox, levels: LocalThresholds, size: Array, width: float, band: float
) -> Single:
    """Compute the height over the local threshold, divided by the slope, within `band` of a particle; NaN elsewhere.

    It is about the distance to the edge, in smallest sides of a voxel.

    Parameters
    ----------
    volume : ndarray of float32, shape (P, R, C)
        Smoothed volume.
    box : VoxelBox
        Part of it, which may reach beyond the border: there the outermost voxels continue.
    levels : LocalThresholds
        Particles and their thresholds.
    size : ndarray, shape (3,)
        Sides of a voxel [smallest sides].
    width : float
        Width of the Gaussian that spreads the thresholds [smallest sides].
    band : float
        Distance from a particle up to which the height is known [smallest sides].

    Returns
    -------
    ndarray of float32, shape `box.shape`
        The height.
    """
    height = np.full(box.shape, np.nan, np.float32)
    radii = np.maximum(band / size, _MIN_BAND_RADIUS)
    reach = max(_GAUSSIAN_CUTOFF * width, float((radii * size).max()))
    places = levels.points - box.begin
    order, begin, cells = _sort_into_cells(places * size, np.array(box.shape) * size, reach)
    points, thresholds, slopes = places[order], levels.thresholds[order], levels.slopes[order]
    _mark_band(height, points, radii)
    weight = -0.5 / width**2

    def compute_planes(first: int, last: int) -> None:
        _compute_height(
            volume, box.begin, height, points, thresholds, slopes, begin, cells, size, reach, weight, first, last
        )

    run_in_parallel(compute_planes, len(height), _MIN_PLANES_PER_THREAD)
    return height


def _sort_into_cells(places: Array, extent: Array, side: float) -> tuple[Index, NDArray[np.int32], Index]:
    """Sort places by cubic cells: their order, the first place of each cell, and the cells along each axis."""
    cells = (extent / side).astype(np.int64) + 1
    at = np.clip((places / side).astype(np.int64), 0, cells - 1)
    cell = (at[:, 0] * cells[1] + at[:, 1]) * cells[2] + at[:, 2]
    counts = np.bincount(cell, minlength=int(np.prod(cells)))
    return np.argsort(cell, kind="stable"), np.concatenate([[0], np.cumsum(counts)]).astype(np.int32), cells


@compiled
def _mark_band(height: Single, points: Array, radii: Array) -> None:
    """Set the voxels of the band to zero."""
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(len(points)):
        for k in range(3):
            low[k] = max(int(np.ceil(points[i, k] - radii[k])), 0)
            high[k] = min(int(np.floor(points[i, k] + radii[k])) + 1, height.shape[k])
        for p in range(low[0], high[0]):
            across = 1.0 - ((p - points[i, 0]) / radii[0]) ** 2
            for r in range(low[1], high[1]):
                left = across - ((r - points[i, 1]) / radii[1]) ** 2
                for c in range(low[2], high[2]):
                    if ((c - points[i, 2]) / radii[2]) ** 2 <= left:
                        height[p, r, c] = 0.0


@compiled
def _compute_height(
    volume: Single,
    origin: Index,
    height: Single,
    points: Array,
    thresholds: Array,
    slopes: Array,
    begin: NDArray[np.int32],
    cells: Index,
    size: Array,
    reach: float,
    weight: float,
    first: int,
    last: int,
) -> None:
    top, bottom, right = volume.shape[0] - 1, volume.shape[1] - 1, volume.shape[2] - 1
    for p in range(first, last):
        plane = min(max(p + origin[0], 0), top)
        a = min(int(p * size[0] / reach), cells[0] - 1)
        for r in range(height.shape[1]):
            row = min(max(r + origin[1], 0), bottom)
            b = min(int(r * size[1] / reach), cells[1] - 1)
            for c in range(height.shape[2]):
                if np.isnan(height[p, r, c]):
                    continue
                d = min(int(c * size[2] / reach), cells[2] - 1)
                total = threshold = slope = 0.0
                for u in range(max(a - 1, 0), min(a + 2, cells[0])):
                    for v in range(max(b - 1, 0), min(b + 2, cells[1])):
                        line = (u * cells[1] + v) * cells[2]
                        for i in range(begin[line + max(d - 1, 0)], begin[line + min(d + 2, cells[2])]):
                            x, y, z = points[i, 0] - p, points[i, 1] - r, points[i, 2] - c
                            off = (x * size[0]) ** 2 + (y * size[1]) ** 2 + (z * size[2]) ** 2
                            if off < reach * reach:
                                part = np.exp(weight * off)
                                total += part
                                threshold += part * thresholds[i]
                                slope += part * slopes[i]
                col = min(max(c + origin[2], 0), right)
                height[p, r, c] = (volume[plane, row, col] * total - threshold) / max(slope, 1e-30)
