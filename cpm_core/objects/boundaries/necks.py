"""Necks: places where a set of pixels is narrower than the bodies on both sides."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.grids import (
    bounding_window,
    expand_window,
    find_high_maxima,
    flood_from_markers,
    label_parts,
    spread_labels,
)
from cpm_core.numerics.types import Array, Index, Mask

_NECK_DEPTH_RATIO = 0.1
"""How much narrower a neck is than both of the bodies that it joins, as a fraction of a radius."""

_MAX_RADIUS = 64.0
"""Radius of the widest body of an image above which its necks are looked for in a coarser mask [px]."""

_MIN_SOLIDITY = 0.75
"""Least volume of the parts of a body, in volumes of their convex hulls, with which it is split."""

_NARROW_NECK_RATIO = 0.5
"""Radius of the widest narrow neck, in radii of the smaller of the two parts that it joins."""

_SAME_HULL_RATIO = 1.02
"""Ratio up to which the volume of two convex hulls is the same."""

_TO_FACES = 0.5 * np.concatenate([np.eye(3), -np.eye(3)])
"""The way from the center of a voxel to those of its faces [voxels]."""


def split_at_clear_necks(mask: Mask, sides: Array | None = None) -> Index:
    """Split a body, shape (P, R, C), at its necks if the parts are nearly convex; else leave it as it is.

    So nuclei are split that touch, but not the parts of a skull. Parts that are no more nearly convex apart, as on two
    sides of a hollow, are one, unless one lies in a hollow of the other, behind a narrow neck. See `split_at_necks`.
    """
    parts = split_at_necks(mask, sides=sides)
    count = int(parts.max(initial=0))
    if count < 2:
        return mask.astype(np.int64)
    hulls = {number: _find_hull(parts == number) for number in range(1, count + 1)}
    depth = _measure_smooth_depth(mask, np.ones(mask.ndim) if sides is None else sides)
    deepest, joined = np.array(scipy.ndimage.maximum(depth, parts, range(count + 1))), np.arange(count + 1)
    for pair, radius in _find_necks(parts, depth):
        one, other = sorted(joined[list(pair)].tolist())
        if one == other:
            continue
        corners = [hull.points[hull.vertices] for hull in (hulls[one], hulls[other])]
        both = scipy.spatial.ConvexHull(np.concatenate(corners))
        volumes = hulls[one].volume, hulls[other].volume
        nested = both.volume <= _SAME_HULL_RATIO * max(volumes)
        narrow = radius <= _NARROW_NECK_RATIO * deepest[[one, other]].min()
        if both.volume <= _SAME_HULL_RATIO * sum(volumes) and not (nested and narrow):
            hulls[one], deepest[one] = both, deepest[[one, other]].max()
            del hulls[other]
            joined[joined == other] = one
    if np.count_nonzero(mask) < _MIN_SOLIDITY * sum(hull.volume for hull in hulls.values()):
        return mask.astype(np.int64)
    return np.searchsorted([0, *sorted(hulls)], joined)[parts]


def _find_necks(parts: Index, depth: Array) -> list[tuple[tuple[int, int], float]]:
    """Find the parts that touch, two by two, with the radius of the neck between them; the widest first."""
    found: dict[tuple[int, int], float] = {}
    for axis in range(parts.ndim):
        (here, near), (there, far) = (
            [np.moveaxis(each, axis, 0)[window] for each in (parts, depth)] for window in (slice(-1), slice(1, None))
        )
        beside = (here != there) & (here > 0) & (there > 0)
        radii = np.minimum(near, far)[beside]
        for one, other, radius in zip(here[beside].tolist(), there[beside].tolist(), radii.tolist(), strict=True):
            pair = min(one, other), max(one, other)
            found[pair] = max(found.get(pair, 0.0), radius)
    return sorted(found.items(), key=lambda each: -each[1])


def measure_hull(mask: Mask) -> float:
    """Measure the volume of the convex hull of the voxels of a mask [voxels]."""
    return float(_find_hull(mask).volume) if mask.any() else 0.0


def _find_hull(mask: Mask) -> scipy.spatial.ConvexHull:
    """Find the convex hull of the voxels of a mask."""
    shell = np.argwhere(mask & ~scipy.ndimage.binary_erosion(mask))
    return scipy.spatial.ConvexHull((shell[:, None] + _TO_FACES).reshape(-1, 3))


def split_at_necks(mask: Mask, radius: float | None = None, sides: Array | None = None) -> Index:
    """Split a mask of an image or a volume at its necks into bodies, numbered from 1; 0 outside.

    A neck is narrower than what it joins by a fraction of a radius [px], by default that of the widest body. `sides`
    are those of a voxel, the smallest being 1.
    """
    parts = np.zeros(mask.shape, np.int64)
    if not mask.any():
        return parts
    window = expand_window(bounding_window(mask), 1, mask.shape)
    near = mask[window]
    sides = np.ones(mask.ndim) if sides is None else sides
    depth = _measure_smooth_depth(near, sides)
    radius = float(depth.max()) if radius is None else radius
    step = int(radius / _MAX_RADIUS)
    if step > 1 and mask.ndim == 2:
        return _split_coarsely(mask, radius, step)
    markers, _ = label_parts(find_high_maxima(depth, max(0.5, _NECK_DEPTH_RATIO * radius)) & near)
    parts[window] = flood_from_markers(-depth, markers, near)
    return parts


def _measure_smooth_depth(mask: Mask, sides: Array) -> Array:
    """Measure how far each pixel of a mask is from the outside, smoothed; the mask continues beyond the grid."""
    depth = scipy.ndimage.distance_transform_edt(np.pad(mask, 1, mode="edge"), sampling=sides)
    smooth: Array = scipy.ndimage.gaussian_filter(depth, 1.0 / sides, mode="nearest")
    return smooth[(slice(1, -1),) * mask.ndim]


def _split_coarsely(mask: Mask, radius: float, step: int) -> Index:
    """Split a mask at its necks on one of `step` pixels along each axis; the others belong to the nearest body."""
    coarse = split_at_necks(mask[::step, ::step], radius / step)
    parts = np.where(mask, coarse.repeat(step, axis=0).repeat(step, axis=1)[: mask.shape[0], : mask.shape[1]], 0)
    if not parts.any():
        return mask.astype(np.int64)
    return np.where(mask, spread_labels(parts), 0).astype(np.int64)
