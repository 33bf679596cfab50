"""The surface on which a volume passes through zero, as triangles: closed, oriented and manifold.

Of scikit-image's two ways of marching cubes only that of Lorensen and Cline leaves no hole at any pattern of signs.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import skimage

from cpm_core.numerics.types import Array, Index, Single

_NEAREST = 1e-3
"""Least size of a value, in the median size: no vertex lies at a voxel, where triangles would have no area."""

_CORNERS = tuple(product((0, 1), repeat=3))
"""Corners of a cube of eight voxels; those of the first four are opposite to those of the last four."""


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
    vertices, faces, _, _ = skimage.measure.marching_cubes(np.where(inside, -size, size), 0.0, method="lorensen")  # type: ignore[no-untyped-call]
    return vertices.astype(float) + begin, faces.astype(np.int64)


def join_corners(values: Single, raised: float) -> None:
    """Raise voxels of a volume so that two above zero that meet at a corner alone hang together over sides as well."""
    inside = values > 0.0
    corners = {at: inside[tuple(slice(k, n - 1 + k) for k, n in zip(at, values.shape, strict=True))] for at in _CORNERS}
    two = np.sum(list(corners.values()), axis=0, dtype=np.uint8) == 2
    for (plane, row, col), corner in zip(_CORNERS[:4], _CORNERS[:3:-1], strict=True):
        joint = np.argwhere(two & corners[plane, row, col] & corners[corner]) + np.array((1 - plane, row, col))
        values[tuple(joint.T)] = raised
