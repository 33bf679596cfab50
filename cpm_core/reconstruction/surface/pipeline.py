"""From particles on the edges of a volume to a surface that is closed, oriented and manifold by construction.

The surface separates the bright from the dark side of the edges, nested walls included. Where two bright regions
of different gray levels touch, both are inside, and a thin slit, which may have bridges, runs along the wall between
them. A thin sheet between two regions of the same gray level is a body with two sides.
"""

from __future__ import annotations

import numpy as np

from cpm_core.field.volume_field import pitch_of
from cpm_core.field.volume_surface import project_all_to_ridge
from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import bridge_corner_contacts, zero_surface
from cpm_core.numerics.types import Array, Mask, Sides, Single
from cpm_core.reconstruction.surface.blur_correction import blurred_edge_width, measure_local_thresholds
from cpm_core.reconstruction.surface.components import (
    fill_unknown_regions,
    has_point_within,
    keep_supported_components,
    set_border_voxels,
    typical_distance,
)
from cpm_core.reconstruction.surface.joints import RAISED_HEIGHT, SaddleSurroundings, bridge_necks, bridge_thin_vessels
from cpm_core.reconstruction.surface.local_threshold import LocalThresholds, VoxelBox, height_over_threshold

_THRESHOLD_SPREAD = 0.75
"""Width of the Gaussian that spreads the thresholds [distances between particles]."""

_MIN_THRESHOLD_SPREAD = 1.5
"""Least width of the Gaussian that spreads the thresholds [smallest sides of a voxel]."""

_BAND_THICKNESS = 1.6
"""Thickness of the band around the particles on each side [distances between particles]."""

_MIN_BAND_THICKNESS = 3.0
"""Least thickness of the band around the particles on each side [smallest sides of a voxel]."""

_RIDGE_STEPS = 6
"""Number of steps of particles to the ridge."""

_MIN_PARTICLES = 4
"""Least number of particles: fewer span no volume."""


def find_surface(
    volume: Single,
    edges: Single,
    points: Array,
    spacing: Sides = (1.0, 1.0, 1.0),
    unit: str | None = None,
    *,
    smoothing: float = 1.0,
    shut: Mask | None = None,
) -> Surface:
    """Find the surface through particles that rest on the edges of a smoothed volume, shape (N, 3) [voxels].

    `smoothing` is the width of the Gaussian that has smoothed it, in smallest sides of a voxel. The surface leaves out
    the voxels that are `shut`: objects get a flat end there, as at the border of the volume. It has no triangles when
    there are fewer than four particles.
    """
    size = np.array(pitch_of(spacing))
    if len(points) < _MIN_PARTICLES:
        return Surface(np.empty(0), np.empty(0, np.int64), spacing, unit)
    levels, normals = find_local_thresholds(volume, edges, points, size, smoothing)
    points = levels.points
    apart = typical_distance(points * size)
    width, band = width_and_band(apart)
    # the bands of all particles, and one voxel more on all sides
    low = np.maximum(np.floor(points.min(0) - band / size).astype(np.int64) - 1, 0)
    high = np.minimum(np.ceil(points.max(0) + band / size).astype(np.int64) + 2, volume.shape)
    planes, rows, cols = (high - low + 2).tolist()
    box = VoxelBox(low - 1, (planes, rows, cols))
    height = height_over_threshold(volume, box, levels, size, width, band)
    left_out = None
    if shut is not None:  # the part of it that lies in the box, which may reach beyond the volume
        along = [np.arange(begin, begin + count) for begin, count in zip(box.begin.tolist(), box.shape, strict=True)]
        left_out = shut[np.ix_(*(np.clip(at, 0, n - 1) for at, n in zip(along, shut.shape, strict=True)))]
    sign = _decide_inside(height, left_out)
    surroundings = SaddleSurroundings(volume, sign, levels.points, sign * normals, levels.slopes, size)
    bridge_necks(height, box.begin, surroundings)
    bridge_thin_vessels(height, box.begin, surroundings, blurred_edge_width(smoothing))
    bridge_corner_contacts(height, RAISED_HEIGHT)
    if left_out is not None:
        height[left_out] = -1.0
    vertices, faces = zero_surface(height)
    vertices += box.begin
    supported = has_point_within(vertices * size, points * size, apart)
    return keep_supported_components(vertices, faces, points, supported, spacing, unit)


def find_local_thresholds(
    volume: Single, edges: Single, points: Array, size: Array, smoothing: float
) -> tuple[LocalThresholds, Array]:
    """Move particles, shape (N, 3) [voxels], to the ridge; return their thresholds, and their normals away from bright.

    The arguments are those of `find_surface`, and `size` holds the sides of a voxel.
    """
    pitch = tuple(size.tolist())
    places = project_all_to_ridge(volume, edges, pitch, points * size, _RIDGE_STEPS) / size
    places = np.clip(places, 0.0, np.array(volume.shape) - 1.0)
    return measure_local_thresholds(volume, edges, places, size, blurred_edge_width(smoothing))


def width_and_band(apart: float) -> tuple[float, float]:
    """Return the width of the Gaussian and the thickness of the band, from the typical distance between particles."""
    return max(_THRESHOLD_SPREAD * apart, _MIN_THRESHOLD_SPREAD), max(_BAND_THICKNESS * apart, _MIN_BAND_THICKNESS)


def _decide_inside(height: Single, left_out: Mask | None) -> float:
    """Decide on every voxel of a height, its rim being outside; return -1 if bright and dark were exchanged.

    An object may be darker than its surroundings: the inside is the side that less of the border lies on.
    """
    if left_out is not None:
        height[left_out] = np.inf
    fill_unknown_regions(height)
    inner = height[1:-1, 1:-1, 1:-1]
    border = [side for axis in range(3) for side in (inner.take(0, axis), inner.take(-1, axis))]
    bright = sum(int((side > 0.0).sum()) for side in border)
    sign = -1.0 if 2 * bright > sum(side.size for side in border) else 1.0
    height *= np.float32(sign)
    set_border_voxels(height, -1.0)
    if left_out is not None:
        height[left_out] = -1.0
    return sign
