"""A surface through points with normals: where the height over the planes of the nearest points is zero.

The points are so dense on a grid of their own that neighbors are two voxels apart. Each gives the height over the
plane through it, weighted by a Gaussian of the distance (implicit moving least squares; Kolluri 2005, DOI
10.1145/1361192.1361195), and marching cubes follow the zero.
"""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Single
from cpm_core.numerics.zero_surface import zero_surface
from cpm_core.reconstruction.surface.iso.sides import fill_regions

_STEPS = 2.0
"""Steps of the grid between neighboring points."""

_WIDTH, _BAND = 1.5, 3.5
"""Width of the Gaussian, and how far from a point the height is known [steps of the grid]."""

_MOST = 400_000_000
"""Largest number of steps of the grid: more need too much memory."""


def implicit_surface(points: Array, normals: Array, apart: float) -> tuple[Array, Index]:
    """Vertices and triangles of a closed surface through points, shape (N, 3), with unit normals outward.

    `apart` is the typical distance between the points, in their unit. ValueError when they are strewn so far apart
    that the grid would not fit into memory.
    """
    step = apart / _STEPS
    begin = points.min(0) - step * (_BAND + 2.0)
    shape = np.ceil((points.max(0) - begin) / step + _BAND + 2.0)
    if not shape.prod() < _MOST:
        raise ValueError(
            f"The points are {apart:g} apart, but spread over {np.ptp(points, axis=0).max():g}: a grid for them would "
            "not fit into memory. Leave out points far from the others, or give fewer."
        )
    height, weight = np.zeros((2, *shape.astype(int)), np.float32)
    _add(height, weight, (points - begin) / step, normals)
    with np.errstate(invalid="ignore"):
        np.divide(height, weight, out=height)
    outermost = np.ones(height.shape, bool)
    outermost[1:-1, 1:-1, 1:-1] = False
    height[outermost] = np.inf
    fill_regions(height)
    height[outermost] = -1.0
    vertices, faces = zero_surface(height)
    return vertices * step + begin, faces


@compiled
def _add(height: Single, weight: Single, points: Array, normals: Array) -> None:
    """Add up the weighted heights below the planes of all points, and the weights."""
    reach = int(_BAND) + 1
    for i in range(len(points)):
        a, b, c = int(points[i, 0]), int(points[i, 1]), int(points[i, 2])
        for p in range(a - reach + 1, a + reach + 1):
            x = p - points[i, 0]
            for r in range(b - reach + 1, b + reach + 1):
                y = r - points[i, 1]
                for s in range(c - reach + 1, c + reach + 1):
                    z = s - points[i, 2]
                    off = x * x + y * y + z * z
                    if off <= _BAND * _BAND:
                        part = np.exp(-0.5 * off / _WIDTH**2)
                        height[p, r, s] -= part * (x * normals[i, 0] + y * normals[i, 1] + z * normals[i, 2])
                        weight[p, r, s] += part
