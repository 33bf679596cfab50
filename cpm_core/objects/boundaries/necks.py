"""Necks: places where a set of pixels is narrower than the bodies on both sides."""

from __future__ import annotations

import numpy as np
import scipy
import skimage

from cpm_core.numerics.grids import flood_from_markers, label_parts
from cpm_core.numerics.types import Array, Index, Mask

_NECK_DEPTH_RATIO = 0.1
"""How much narrower a neck is than both of the bodies that it joins, as a fraction of a radius."""

_MAX_RADIUS = 64.0
"""Radius of the widest body of an image above which its necks are looked for in a coarser mask [px]."""


def split_at_necks(mask: Mask, radius: float | None = None, sides: Array | None = None) -> Index:
    """Split a mask of an image or a volume at its necks into bodies, numbered from 1; 0 outside.

    A neck is narrower than what it joins by a fraction of a radius [px], by default that of the widest body. `sides`
    are those of a voxel, the smallest being 1.
    """
    inner = (slice(1, -1),) * mask.ndim
    sides = np.ones(mask.ndim) if sides is None else sides
    depth = scipy.ndimage.distance_transform_edt(np.pad(mask, 1, mode="edge"), sampling=sides)
    depth = scipy.ndimage.gaussian_filter(depth, 1.0 / sides, mode="nearest")[inner]
    radius = float(depth.max()) if radius is None else radius
    step = int(radius / _MAX_RADIUS)
    if step > 1 and mask.ndim == 2:
        return _split_coarsely(mask, radius, step)
    tops = skimage.morphology.h_maxima(depth, max(0.5, _NECK_DEPTH_RATIO * radius))  # type: ignore[no-untyped-call]
    markers, _ = label_parts((tops > 0) & mask)
    return flood_from_markers(-depth, markers, mask).astype(np.int64)


def _split_coarsely(mask: Mask, radius: float, step: int) -> Index:
    """Split a mask at its necks on one of `step` pixels along each axis; the others belong to the nearest body."""
    coarse = split_at_necks(mask[::step, ::step], radius / step)
    parts = np.where(mask, coarse.repeat(step, axis=0).repeat(step, axis=1)[: mask.shape[0], : mask.shape[1]], 0)
    if not parts.any():
        return mask.astype(np.int64)
    nearest = scipy.ndimage.distance_transform_edt(parts == 0, return_distances=False, return_indices=True)
    return np.asarray(np.where(mask, parts[tuple(nearest)], 0), np.int64)
