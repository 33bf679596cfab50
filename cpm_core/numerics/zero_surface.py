"""The surface on which a volume passes through zero, as triangles: closed, oriented and manifold.

Of scikit-image's two ways of marching cubes only that of Lorensen and Cline leaves no hole at any pattern of signs.
"""

from __future__ import annotations

import numpy as np
from skimage.measure import marching_cubes

from cpm_core.numerics.types import Array, Index, Single

_NEAREST = 1e-3
"""Least size of a value, in the median size: no vertex lies at a voxel, where triangles would have no area."""


def zero_surface(values: Single, inner: tuple[tuple[int, int], ...] | None = None) -> tuple[Array, Index]:
    """Vertices [voxels], shape (N, 3), and triangles, shape (F, 3), of the surface around the voxels above zero.

    Seen from outside, triangles run counter-clockwise. Voxels inside hang together over sides and edges, those outside
    over sides alone. `inner` is the range of voxels to consider along each axis; the surface is open where it leaves
    that range.
    """
    begin, end = np.transpose(inner if inner is not None else [(0, size) for size in values.shape])
    part = values[tuple(map(slice, begin, end))]
    inside = part > 0.0
    if min(part.shape) < 2 or inside.all() or not inside.any():
        return np.empty((0, 3)), np.empty((0, 3), np.int64)
    size = np.abs(part)
    size = np.maximum(size, np.float32(_NEAREST) * np.median(size))
    vertices, faces, _, _ = marching_cubes(np.where(inside, -size, size), 0.0, method="lorensen")  # type: ignore[no-untyped-call]
    return vertices.astype(float) + begin, faces.astype(np.int64)
