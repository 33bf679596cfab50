"""Components of a surface that enough particles bear out, and regions away from particles that lie inside."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.contours.surface import Surface
from cpm_core.numerics.grids import parts_of
from cpm_core.numerics.types import Array, Index, Mask, Single

_APART = 4
"""The distance to this neighbor is about that between points, in regular patterns and at random."""


_FEWEST, _SHARE, _SUPPORTED = 12, 0.003, 0.25
"""A component stays if it has so many particles, and so many as a share of those of the component with most of them,
and if this share of its vertices has a particle near."""


def support(vertices: Array, points: Array, distance: float) -> Mask:
    """Which vertices have a point within a distance."""
    return np.asarray(scipy.spatial.KDTree(points).query(vertices)[0] <= distance)


def well_supported(
    vertices: Array,
    faces: Index,
    points: Array,
    supported: Mask,
    spacing: tuple[float, ...],
    unit: str | None,
) -> Surface:
    """Surface of the components that are not left out; `supported` marks which vertices have a particle near.

    A particle belongs to the component of the vertex next to it.
    """
    whole = Surface(vertices, faces, spacing, unit)
    if not len(faces):
        return whole
    component = whole.component_of_vertex
    nearest = scipy.spatial.KDTree(vertices * spacing).query(points * spacing)[1]
    particles = np.bincount(component[nearest], minlength=component.max() + 1)
    share = np.bincount(component, supported) / np.bincount(component)
    kept = (particles >= max(_FEWEST, _SHARE * particles.max())) & (share >= _SUPPORTED)
    stays = kept[component]
    number = np.cumsum(stays) - 1
    unsupported = 1.0 - float(supported[stays].mean()) if stays.any() else np.nan
    left_out = int(len(kept) - kept.sum())
    return Surface(vertices[stays], number[faces[stays[faces[:, 0]]]], spacing, unit, unsupported, left_out)


def typical_distance(places: Array) -> float:
    """Typical distance between neighboring places, shape (N, 3), in their unit."""
    distances = scipy.spatial.KDTree(places).query(places, [min(_APART, len(places) - 1) + 1])[0]
    return float(np.median(distances))


FAR = 4.0
"""Height inside, and less than zero outside, of voxels away from all particles."""


def fill_regions(height: Single, left_out: Mask | None = None) -> Mask:
    """Replace NaN in a height by `FAR` or its negative, region by region.

    The outermost voxels, and those that are left out, belong to no region; they are returned.
    """
    apart = np.ones(height.shape, np.bool_)
    apart[1:-1, 1:-1, 1:-1] = False
    if left_out is not None:
        apart |= left_out
    height[apart] = np.inf
    unknown = np.isnan(height)
    regions = parts_of(unknown, corners=False)
    side = np.where(np.isfinite(height), np.where(height > 0.0, 1, -1), 0).astype(np.int8)
    around = np.zeros_like(side)
    for axis in range(3):
        found, near = np.moveaxis(around, axis, 0), np.moveaxis(side, axis, 0)
        found[1:] += near[:-1]
        found[:-1] += near[1:]
    votes = np.bincount(regions.labels[unknown], around[unknown], minlength=regions.count + 1)
    height[unknown] = np.where(votes > 0, FAR, -FAR)[regions.labels[unknown]]
    return apart
