"""Unambiguous edges: about as strong all along, and much stronger than the edges inside."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Mask

_ALLOWED_PERCENTAGE = 5.0
"""Percentage of an edge, and of its inside, that need not fit."""

_MIN_EDGE_RATIO = 3.0
"""Least ratio of the strength of the edge to that of its inside."""

_MIN_WEAK_FRACTION = 0.5
"""Least strength of weak stretches of the edge, in multiples of its median: a weaker edge lies in something larger."""

OWN_EDGE_DISTANCE = 3.0
"""Distance from an edge up to which the edge strength is its own [px]."""

_EIGHT_NEIGHBORS = np.ones((3, 3), np.bool_)
"""Neighbors of a pixel."""

_RIDGE_DISTANCE = 2
"""Distance from a region up to which a ridge is part of the edges around it [px]."""


def is_unambiguous(along: Array, inside: Array) -> bool:
    """Return whether the image leaves no doubt about a closed edge.

    Parameters
    ----------
    along : ndarray, shape (N,)
        Edge strength along it.
    inside : ndarray, shape (M,)
        Edge strength of the pixels that it encloses, farther than `OWN_EDGE_DISTANCE` from it. Without any it is a
        detail, which stays ambiguous.
    """
    if not along.size or not inside.size:
        return False
    weak, usual = np.percentile(along, [_ALLOWED_PERCENTAGE, 50.0])
    return bool(
        weak > max(_MIN_EDGE_RATIO * np.percentile(inside, 100.0 - _ALLOWED_PERCENTAGE), _MIN_WEAK_FRACTION * usual)
    )


def unambiguous_edges(strength: Array, ridge: Mask, area: Mask) -> Mask:
    """Find the edges around the region that holds most of a start, if they are unambiguous.

    They bound the object of the start even where it has been drawn across them, or where the boundary of its basin
    misses narrow parts and weak corners.

    Parameters
    ----------
    strength : ndarray, shape (H, W)
        Edge map.
    ridge : ndarray of bool, shape (H, W)
        Pixels on the ridges of all edges.
    area : ndarray of bool, shape (H, W)
        Area that the start covers.

    Returns
    -------
    ndarray of bool, shape (H, W)
        Pixels of the ridges around the region and its holes; none where it is ambiguous, or reaches the border of the
        image.
    """
    found = np.zeros_like(ridge)
    regions, _ = scipy.ndimage.label(~scipy.ndimage.binary_dilation(ridge, _EIGHT_NEIGHBORS))
    held = np.bincount(regions[area])
    held[:1] = 0
    if not held.any() or 2 * held.max() <= np.count_nonzero(area):
        return found
    number = int(held.argmax())
    sides = scipy.ndimage.find_objects(regions, number)[number - 1] or ()
    if any(side.start == 0 or side.stop == length for side, length in zip(sides, ridge.shape, strict=True)):
        return found
    box = tuple(slice(max(side.start - _RIDGE_DISTANCE, 0), side.stop + _RIDGE_DISTANCE) for side in sides)
    found[box] = _edges_around(strength[box], ridge[box], regions[box] == number)
    return found


def _edges_around(strength: Array, ridge: Mask, region: Mask) -> Mask:
    """Return the edges around a region, pixels of a ridge, if they are unambiguous."""
    beside = ridge & scipy.ndimage.binary_dilation(region, _EIGHT_NEIGHBORS, _RIDGE_DISTANCE)
    filled = np.asarray(scipy.ndimage.binary_fill_holes(region))
    depth = scipy.ndimage.distance_transform_edt(filled)
    outer = beside & (depth == 0.0)
    holes = _hole_edges(strength, beside, filled & ~region)
    away = np.minimum(depth, scipy.ndimage.distance_transform_edt(~holes)) if holes.any() else depth
    if not is_unambiguous(strength[outer], strength[away > OWN_EDGE_DISTANCE]):
        return np.zeros_like(ridge)
    return outer | (beside & (strength > _MIN_WEAK_FRACTION * np.median(strength[outer])))


def _hole_edges(strength: Array, ridge: Mask, islands: Mask) -> Mask:
    """Return the edges, pixels of a ridge, of the unambiguous islands in a region: holes or objects."""
    found = np.zeros_like(ridge)
    parts, _ = scipy.ndimage.label(islands, _EIGHT_NEIGHBORS)
    for number, box in enumerate(scipy.ndimage.find_objects(parts), start=1):
        island = np.pad(parts[box] == number, 1)
        depth = scipy.ndimage.distance_transform_edt(island)[1:-1, 1:-1]
        edge = ridge[box] & (depth > 0.0)
        within = (depth > OWN_EDGE_DISTANCE) & (scipy.ndimage.distance_transform_edt(~edge) > OWN_EDGE_DISTANCE)
        if is_unambiguous(strength[box][edge], strength[box][within]):
            found[box] |= edge
    return found
