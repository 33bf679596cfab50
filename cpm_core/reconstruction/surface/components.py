"""Components of a surface with enough particles, and the side of regions away from all particles."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import ConnectedParts, find_connected_parts
from cpm_core.numerics.types import Array, Index, Mask, Sides, Single

_NEIGHBOR_RANK = 4
"""Rank of the neighbor whose distance is about that between points, in regular patterns and at random."""


_MIN_COMPONENT_PARTICLES = 12
"""Least number of particles of a component that stays."""

_MIN_PARTICLE_SHARE = 0.003
"""Least number of particles of a component that stays, as a share of those of the component with most of them."""

_MIN_SUPPORTED_SHARE = 0.25
"""Least share of the vertices of a component that have a particle near, for it to stay."""


def has_point_within(vertices: Array, points: Array, distance: float) -> Mask:
    """Return whether vertices, shape (N, 3), have one of the points, shape (M, 3), within a distance, shape (N,)."""
    return np.asarray(scipy.spatial.KDTree(points).query(vertices)[0] <= distance)


def keep_supported_components(
    vertices: Array,
    faces: Index,
    points: Array,
    supported: Mask,
    spacing: Sides,
    unit: str | None,
) -> Surface:
    """Keep the components of a surface that enough particles support.

    A particle belongs to the component of the vertex next to it.

    Parameters
    ----------
    vertices : ndarray, shape (N, 3)
        Vertices [voxels].
    faces : ndarray of int64, shape (F, 3)
        Vertices of each triangle.
    points : ndarray, shape (M, 3)
        Particles [voxels].
    supported : ndarray of bool, shape (N,)
        Whether each vertex has a particle near.
    spacing, unit
        Size of a voxel along each axis, and its unit.
    """
    whole = Surface(vertices, faces, spacing, unit)
    if not len(faces):
        return whole
    component = whole.component_of_vertex
    nearest = scipy.spatial.KDTree(vertices * spacing).query(points * spacing)[1]
    particles = np.bincount(component[nearest], minlength=component.max() + 1)
    share = np.bincount(component, supported) / np.bincount(component)
    kept = has_enough_support(particles, share)
    stays = kept[component]
    number = np.cumsum(stays) - 1
    unsupported = 1.0 - float(supported[stays].mean()) if stays.any() else np.nan
    left_out = int(len(kept) - kept.sum())
    return Surface(vertices[stays], number[faces[stays[faces[:, 0]]]], spacing, unit, unsupported, left_out)


def has_enough_support(particles: Index, share: Array) -> Mask:
    """Return whether components have enough particles, and share of vertices with one near; all of shape (C,)."""
    return (particles >= max(_MIN_COMPONENT_PARTICLES, _MIN_PARTICLE_SHARE * particles.max(initial=0))) & (
        share >= _MIN_SUPPORTED_SHARE
    )


def typical_distance(places: Array) -> float:
    """Return the typical distance between neighboring places, shape (N, 3), in their unit."""
    return float(np.median(neighbor_distances(places)))


def neighbor_distances(places: Array) -> Array:
    """Measure the distance of places, shape (N, 3), from about their nearest neighbors, shape (N,), in their unit."""
    return np.asarray(scipy.spatial.KDTree(places).query(places, [min(_NEIGHBOR_RANK, len(places) - 1) + 1])[0])[:, 0]


HEIGHT_AWAY_FROM_PARTICLES = 4.0
"""Height of voxels inside, and its negative for those outside, away from all particles."""


def fill_unknown_regions(height: Single) -> None:
    """Replace NaN in a height, shape (P, R, C), region by region, by the sign of most of the voxels around.

    The value is `HEIGHT_AWAY_FROM_PARTICLES` or its negative. The outermost voxels become infinite: they belong to no
    region, nor do others that are infinite.
    """
    parts, votes = vote_on_unknown_regions(height)
    parts.fill_voxels(
        np.where(votes > 0, np.float32(HEIGHT_AWAY_FROM_PARTICLES), np.float32(-HEIGHT_AWAY_FROM_PARTICLES)), height
    )


def vote_on_unknown_regions(height: Single) -> tuple[ConnectedParts, Index]:
    """Find regions of NaN in a height, shape (P, R, C), and for each the surplus of voxels around above zero."""
    set_border_voxels(height, np.inf)
    parts = find_connected_parts(np.isnan(height), corners=False)
    side = np.where(np.isfinite(height), np.where(height > 0.0, np.int8(1), np.int8(-1)), np.int8(0))
    votes = np.zeros(parts.count, np.int64)
    for p in range(1, len(height) - 1):
        around = side[p - 1] + side[p + 1]
        around[1:-1] += side[p, :-2] + side[p, 2:]
        around[:, 1:-1] += side[p, :, :-2] + side[p, :, 2:]
        inside = parts.labels[p] > 0
        votes += np.bincount(parts.labels[p][inside] - 1, around[inside], parts.count).astype(np.int64)
    return parts, votes


def set_border_voxels(height: Single, value: float) -> None:
    """Set the outermost voxels of a height, shape (P, R, C)."""
    for axis in range(3):
        np.moveaxis(height, axis, 0)[[0, -1]] = value
