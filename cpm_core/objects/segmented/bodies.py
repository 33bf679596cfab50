"""The union of two objects in a volume, with a closed surface."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.contours.surface import Surface
from cpm_core.contours.surface.distances import Triangles
from cpm_core.contours.surface.packing import PackedSurface
from cpm_core.image.volume_regions import Voxels
from cpm_core.numerics.grids import zero_surface
from cpm_core.numerics.types import Array, Index

_MARGIN = 3
"""Width around the surfaces in which distances are taken [voxels]."""

_NEAR = 2.5
"""Distance from a surface up to which that of a voxel is exact [voxels]."""

_BLEND = 2.0
"""Range of distances that are blended [voxels]: a slit between objects up to half as wide is closed."""


def surface_of_both(first: PackedSurface, second: PackedSurface) -> PackedSurface:
    """A surface around all that two surfaces enclose.

    Those of objects that do not come near each other stay as they are. Else it is where the smaller of the signed
    distances from the two is zero; between surfaces that face each other the distances are blended by the polynomial
    smooth minimum (I. Quilez, 2013), which closes the slit between objects that touch.
    """
    one, other = first.surface, second.surface
    low = np.minimum(one.vertices.min(axis=0), other.vertices.min(axis=0))
    high = np.maximum(one.vertices.max(axis=0), other.vertices.max(axis=0))
    begin = np.floor(low).astype(np.int64) - _MARGIN
    shape = tuple((np.ceil(high).astype(np.int64) + _MARGIN + 1 - begin).tolist())
    here, there = (_signed(packed.voxels, packed.surface, begin, shape) for packed in (first, second))
    if not ((here <= _BLEND) & (there <= _BLEND)).any():
        faces = np.concatenate([one.faces, other.faces + len(one.vertices)])
        return PackedSurface.of(Surface(np.concatenate([one.vertices, other.vertices]), faces))
    blend = np.maximum(_BLEND - np.abs(here - there), 0.0)
    facing = -sum(a * b for a, b in zip(np.gradient(here), np.gradient(there), strict=True))
    level = np.minimum(here, there) - np.clip(facing, 0.0, 1.0) * blend**2 / (4.0 * _BLEND)
    vertices, triangles = zero_surface(-level.astype(np.float32))
    return PackedSurface.of(Surface(vertices + begin, triangles))


def _signed(voxels: Voxels, surface: Surface, begin: Index, shape: tuple[int, ...]) -> Array:
    """Distance of the voxels of a part of a volume from a surface, negative inside, exact near it [voxels]."""
    inside = np.zeros(shape, np.bool_)
    assert voxels.first is not None
    Voxels(voxels.mask, tuple((np.array(voxels.first) - begin).tolist())).fill(inside)
    away = np.where(inside, scipy.ndimage.distance_transform_edt(inside), scipy.ndimage.distance_transform_edt(~inside))
    near = away <= _NEAR
    triangles = Triangles((surface.vertices - begin)[surface.faces])
    away = np.maximum(away - 0.5, 0.5)
    away[near] = triangles.distances(np.argwhere(near).astype(np.float64))
    return np.asarray(np.where(inside, -away, away))
