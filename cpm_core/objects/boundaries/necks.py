"""Necks: places where a set of pixels is narrower than the bodies on both sides."""

from __future__ import annotations

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import bounding_window, expand_window, flood_from_markers, label_parts, spread_labels
from cpm_core.numerics.types import Array, Index, Mask

_NECK_DEPTH_RATIO = 0.1
"""How much narrower a neck is than both of the bodies that it joins, as a fraction of a radius."""

_MAX_RADIUS = 64.0
"""Radius of the widest body of an image above which its necks are looked for in a coarser mask [px]."""


_MIN_SOLIDITY = 0.75
"""Least volume of the parts of a body, in volumes of their convex hulls, with which it is split."""

_TO_FACES = 0.5 * np.concatenate([np.eye(3), -np.eye(3)])
"""The way from the center of a voxel to those of its faces [voxels]."""


def split_at_clear_necks(mask: Mask, sides: Array | None = None) -> Index:
    """Split a body, shape (P, R, C), at its necks if the parts are nearly convex; else leave it as it is.

    So nuclei are split that touch, but not the parts of a skull. See `split_at_necks`.
    """
    parts = split_at_necks(mask, sides=sides)
    hulls = sum(measure_hull(parts == number) for number in range(1, int(parts.max(initial=0)) + 1))
    return parts if np.count_nonzero(mask) >= _MIN_SOLIDITY * hulls else mask.astype(np.int64)


def measure_hull(mask: Mask) -> float:
    """Measure the volume of the convex hull of the voxels of a mask [voxels]."""
    shell = np.argwhere(mask & ~scipy.ndimage.binary_erosion(mask))
    corners = (shell[:, None] + _TO_FACES).reshape(-1, 3)
    return float(scipy.spatial.ConvexHull(corners).volume) if len(shell) else 0.0


def split_at_necks(mask: Mask, radius: float | None = None, sides: Array | None = None) -> Index:
    """Split a mask of an image or a volume at its necks into bodies, numbered from 1; 0 outside.

    A neck is narrower than what it joins by a fraction of a radius [px], by default that of the widest body. `sides`
    are those of a voxel, the smallest being 1.
    """
    parts = np.zeros(mask.shape, np.int64)
    if not mask.any():
        return parts
    window = expand_window(bounding_window(mask), 1, mask.shape)
    inner, near = (slice(1, -1),) * mask.ndim, mask[window]
    sides = np.ones(mask.ndim) if sides is None else sides
    depth = scipy.ndimage.distance_transform_edt(np.pad(near, 1, mode="edge"), sampling=sides)
    depth = scipy.ndimage.gaussian_filter(depth, 1.0 / sides, mode="nearest")[inner]
    radius = float(depth.max()) if radius is None else radius
    step = int(radius / _MAX_RADIUS)
    if step > 1 and mask.ndim == 2:
        return _split_coarsely(mask, radius, step)
    tops = skimage.morphology.h_maxima(depth, max(0.5, _NECK_DEPTH_RATIO * radius))  # type: ignore[no-untyped-call]
    markers, _ = label_parts((tops > 0) & near)
    parts[window] = flood_from_markers(-depth, markers, near)
    return parts


def _split_coarsely(mask: Mask, radius: float, step: int) -> Index:
    """Split a mask at its necks on one of `step` pixels along each axis; the others belong to the nearest body."""
    coarse = split_at_necks(mask[::step, ::step], radius / step)
    parts = np.where(mask, coarse.repeat(step, axis=0).repeat(step, axis=1)[: mask.shape[0], : mask.shape[1]], 0)
    if not parts.any():
        return mask.astype(np.int64)
    return np.where(mask, spread_labels(parts), 0).astype(np.int64)
