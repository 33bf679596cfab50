"""Particles on an edge in a volume, to a fraction of a voxel: on the ridge of the edge map, and where the edge was.

Smoothing moves a curved edge. A ball or a tube shrinks a little, a hollow grows, and anything thinner than the
Gaussian swells. The movement depends on the two principal curvatures, one independently of the other, and is undone.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import scipy

from cpm_core.field.interpolation import interpolate_field
from cpm_core.numerics.types import Array, Single
from cpm_core.reconstruction.surface.local_threshold import LocalThresholds

_VOXEL_VARIANCE = 0.3
"""Variance that the area of the voxels, interpolation and differences add to that of the Gaussian [voxels²]."""

_MAX_EDGE_SHIFT = 1.0
"""Largest movement that is undone, in widths of the smoothed step."""


def interpolate_gray(volume: Single, points: Array) -> Array:
    """Interpolate the gray levels of a volume at points, shape (N, 3) [voxels], shape (N,)."""
    return interpolate_field(volume[None], points)[:, 0]


def blurred_edge_width(smoothing: float) -> float:
    """Return the width of a sharp edge as seen after a Gaussian of width `smoothing` [smallest sides]."""
    return float(np.sqrt(smoothing**2 + _VOXEL_VARIANCE))


def measure_local_thresholds(
    volume: Single, edges: Single, points: Array, size: Array, width: float
) -> tuple[LocalThresholds, Array]:
    """Measure the thresholds and slopes of particles on a ridge, shape (N, 3) [voxels], and their normals (N, 3).

    Normals point away from the bright side. `size` holds the sides of a voxel, and `width` is that of a smoothed step,
    both in smallest sides of a voxel.
    """
    normals, bent = _normals_and_curvatures(volume, points, size)
    curved, shift = _tube_shift_table()
    off = (np.sign(bent) * np.interp(np.abs(width * bent), curved, shift)).sum(1)  # in widths of the smoothed step
    thresholds = interpolate_gray(volume, points + (width * off)[:, None] * normals / size)
    return LocalThresholds(points, thresholds, interpolate_gray(edges, points)), normals


def _normals_and_curvatures(volume: Single, points: Array, size: Array) -> tuple[Array, Array]:
    """Compute unit vectors against the slope of a volume at points [voxels], and the principal curvatures there.

    Both are in units of length. The curvatures are those of the surfaces of equal gray level, positive where bright is
    convex.
    """
    steps, at = np.eye(3), interpolate_gray(volume, points)
    ahead, behind = ([interpolate_gray(volume, points + sign * step) for step in steps] for sign in (1, -1))
    second = np.empty((len(points), 3, 3))
    for a in range(3):
        second[:, a, a] = (ahead[a] - 2.0 * at + behind[a]) / size[a] ** 2
        for b in range(a):
            mixed = sum(
                s * t * interpolate_gray(volume, points + (s * steps[a] + t * steps[b]))
                for s in (1, -1)
                for t in (1, -1)
            )
            second[:, a, b] = second[:, b, a] = mixed / (4.0 * size[a] * size[b])
    slope = np.stack([(ahead[a] - behind[a]) / (2.0 * size[a]) for a in range(3)], 1)
    steepness = np.maximum(np.linalg.norm(slope, axis=1), 1e-30)
    normals = -slope / steepness[:, None]
    flat = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    bend = -flat @ second @ flat / steepness[:, None, None]
    values = np.linalg.eigvalsh(bend)
    order = np.argsort(np.abs(values), axis=1)  # the direction of the normal has none
    return normals, np.take_along_axis(values, order[:, 1:], axis=1)


@cache
def _tube_shift_table() -> tuple[Array, Array]:
    """Tabulate the curvature of the ridge, and the shift of its radius, of tubes under a Gaussian of width 1."""
    radii = np.geomspace(40.0, 0.05, 200)
    around = np.linspace(0.5, 46.0, 9101)
    ridges = []
    for radius in radii:
        slope = np.exp(-0.5 * (around - radius) ** 2) * scipy.special.ive(1, around * radius)
        k = int(slope.argmax())
        bend = slope[k - 1] - 2.0 * slope[k] + slope[k + 1]
        ridges.append(around[k] - 0.5 * (slope[k + 1] - slope[k - 1]) / bend * (around[1] - around[0]))
    found = np.array(ridges)
    return np.concatenate([[0.0], 1.0 / found]), np.concatenate([[0.0], np.maximum(radii - found, -_MAX_EDGE_SHIFT)])
