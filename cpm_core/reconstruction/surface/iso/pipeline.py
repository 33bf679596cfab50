"""From particles on the edges of a volume to a surface that is closed, oriented and manifold by construction."""

from __future__ import annotations

import numpy as np

from cpm_core.contours.surface import Surface
from cpm_core.numerics.types import Array, Index, Single
from cpm_core.reconstruction.surface.components import Leaving, support, well_supported
from cpm_core.reconstruction.surface.iso.joints import join
from cpm_core.reconstruction.surface.iso.local_threshold import Box, Levels, height
from cpm_core.reconstruction.surface.iso.marching import zero_surface
from cpm_core.reconstruction.surface.iso.necks import Surroundings
from cpm_core.reconstruction.surface.iso.sharpened import levels_at, on_ridge, step_width
from cpm_core.reconstruction.surface.iso.sides import fill_regions
from cpm_core.reconstruction.surface.iso.threads import spin
from cpm_core.reconstruction.surface.sampling import typical_distance

_WIDTH, _LEAST_WIDTH = 0.75, 1.5
"""Width of the Gaussian that spreads the thresholds: in distances between particles, and at least [smallest sides]."""

_BAND, _LEAST_BAND = 1.6, 3.0
"""Thickness of the band around the particles on each side, likewise."""

_FEWEST = 4
"""Least number of particles: fewer span no volume."""


def find_surface(
    volume: Single,
    edge_map: Single,
    points: Array,
    spacing: tuple[float, ...] = (1.0, 1.0, 1.0),
    unit: str | None = None,
    *,
    smoothing: float = 1.0,
    open_border: bool = False,
    leaving: Leaving = Leaving(),  # noqa: B008 - a frozen value
) -> Surface:
    """Surface through particles that rest on the edges of a volume.

    Parameters
    ----------
    volume, edge_map : ndarray of float32, shape (P, R, C)
        Smoothed volume, and the length of its gradient.
    points : ndarray, shape (N, 3)
        Particles on edges [voxels].
    spacing : tuple of float
        Size of a voxel along each axis, in `unit`.
    unit : str, optional
        Unit of length.
    smoothing : float
        Width of the Gaussian that has smoothed the volume, in smallest sides of a voxel.
    open_border : bool
        Whether the surface ends at the border of the volume; else objects that the border cuts get a flat end there.
    leaving : Leaving
        Which components are left out.

    Returns
    -------
    Surface
        Without triangles when there are fewer than four particles.
    """
    size = np.array(spacing) / min(spacing)
    if len(points) < _FEWEST:
        return Surface(np.empty((0, 3)), np.empty((0, 3), np.int64), spacing, unit)
    points = on_ridge(volume, edge_map, points, size)
    levels, normals = levels_at(volume, edge_map, points, size, step_width(smoothing))
    apart = typical_distance(points * size)
    width, band = max(_WIDTH * apart, _LEAST_WIDTH), max(_BAND * apart, _LEAST_BAND)
    box = _box(points, volume.shape, band / size)
    found = height(volume, box, levels, size, width, band)
    _join_parts(found, box.begin, volume, levels, normals, size, step_width(smoothing))
    vertices, faces = zero_surface(found, _inner(box, volume.shape) if open_border else None)
    vertices += box.begin
    supported = support(vertices * size, points * size, apart)
    return well_supported(vertices, faces, points, supported, spacing, unit, leaving)


def _join_parts(
    found: Single, begin: Index, volume: Single, levels: Levels, normals: Array, size: Array, width: float
) -> None:
    """Decide on every voxel of a height, and join parts of the inside that hang together."""
    sign = _settle(found)
    surroundings = Surroundings(volume, sign, levels.points, sign * normals, levels.slopes, size)
    join(found, begin, surroundings)
    spin(found, begin, surroundings, width)


def _box(points: Array, shape: tuple[int, ...], band: Array) -> Box:
    """The part of a volume that holds the bands of all particles, and one voxel more on all sides."""
    low = np.maximum(np.floor(points.min(0) - band).astype(np.int64) - 1, 0)
    high = np.minimum(np.ceil(points.max(0) + band).astype(np.int64) + 2, shape)
    planes, rows, cols = (high - low + 2).tolist()
    return Box(low - 1, (planes, rows, cols))


def _inner(box: Box, shape: tuple[int, ...]) -> tuple[tuple[int, int], ...]:
    """Range of a box along each axis without the voxels beyond the border of the volume."""
    return tuple(
        (int(begin < 0), count - int(begin + count > full))
        for begin, count, full in zip(box.begin.tolist(), box.shape, shape, strict=True)
    )


def _settle(found: Single) -> float:
    """Decide on every voxel of a height, the outermost being outside; return -1 if bright and dark were exchanged.

    An object may be darker than what is around it: the inside is not on the side that most of the border lies on.
    """
    outermost = np.ones(found.shape, bool)
    outermost[1:-1, 1:-1, 1:-1] = False
    found[outermost] = np.inf
    fill_regions(found)
    inner = found[1:-1, 1:-1, 1:-1]
    border = [side for axis in range(3) for side in (inner.take(0, axis), inner.take(-1, axis))]
    bright = sum(int((side > 0.0).sum()) for side in border)
    sign = -1.0 if 2 * bright > sum(side.size for side in border) else 1.0
    found *= np.float32(sign)
    found[outermost] = -1.0
    return sign
