"""Edges that are beyond doubt: about as strong all along, and much stronger than whatever they enclose."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Mask

_NEARLY, _STRONGER, _EVEN = 5.0, 3.0, 0.5
"""Percentage of an edge, and of what it encloses, that may be otherwise; how much stronger the edge must be; and the
least strength of its weak stretches, in multiples of its median: a weaker one is an edge within something larger."""

MARGIN = 3.0
"""Distance from an edge up to which the edge strength is its own [px]."""

_AROUND, _BESIDE = np.ones((3, 3), np.bool_), 2
"""Neighbors of a pixel; and the distance from a region up to which a ridge is part of the edges around it [px]."""


def is_certain(along: Array, inside: Array) -> bool:
    """Whether the image leaves no doubt about a closed edge.

    Parameters
    ----------
    along : ndarray, shape (N,)
        Edge strength along it.
    inside : ndarray, shape (M,)
        Edge strength of the pixels that it encloses, farther than `MARGIN` from it. Without any it is a detail, about
        which nothing is certain.
    """
    if not along.size or not inside.size:
        return False
    weak, usual = np.percentile(along, [_NEARLY, 50.0])
    return bool(weak > max(_STRONGER * np.percentile(inside, 100.0 - _NEARLY), _EVEN * usual))


def certain_edges(strength: Array, ridge: Mask, area: Mask) -> Mask:
    """The edges around the region that holds most of a start, if they are certain.

    They bound what the start means also where it has been drawn across them, or where the boundary of its basin misses
    narrow parts and weak corners.

    Parameters
    ----------
    strength : ndarray, shape (H, W)
        Edge map.
    ridge : ndarray of bool, shape (H, W)
        Pixels on the ridges of all edges.
    area : ndarray of bool, shape (H, W)
        What the start covers.

    Returns
    -------
    ndarray of bool, shape (H, W)
        Pixels of the ridges around the region and its holes; none where it is not certain, or reaches the border of the
        image.
    """
    found = np.zeros_like(ridge)
    regions, _ = scipy.ndimage.label(~scipy.ndimage.binary_dilation(ridge, _AROUND))
    held = np.bincount(regions[area])
    held[:1] = 0
    if not held.any() or 2 * held.max() <= np.count_nonzero(area):
        return found
    number = int(held.argmax())
    sides = scipy.ndimage.find_objects(regions, number)[number - 1] or ()
    if any(side.start == 0 or side.stop == length for side, length in zip(sides, ridge.shape, strict=True)):
        return found
    box = tuple(slice(max(side.start - _BESIDE, 0), side.stop + _BESIDE) for side in sides)
    found[box] = _edges_around(strength[box], ridge[box], regions[box] == number)
    return found


def _edges_around(strength: Array, ridge: Mask, region: Mask) -> Mask:
    """The edges around a region, pixels of a ridge, if they are certain."""
    beside = ridge & scipy.ndimage.binary_dilation(region, _AROUND, _BESIDE)
    filled = np.asarray(scipy.ndimage.binary_fill_holes(region))
    depth = scipy.ndimage.distance_transform_edt(filled)
    outer = beside & (depth == 0.0)
    holes = _holes(strength, beside, filled & ~region)
    away = np.minimum(depth, scipy.ndimage.distance_transform_edt(~holes)) if holes.any() else depth
    if not is_certain(strength[outer], strength[away > MARGIN]):
        return np.zeros_like(ridge)
    return outer | (beside & (strength > _EVEN * np.median(strength[outer])))


def _holes(strength: Array, ridge: Mask, islands: Mask) -> Mask:
    """The edges, pixels of a ridge, of those islands in a region that are certain themselves: holes or objects."""
    found = np.zeros_like(ridge)
    parts, _ = scipy.ndimage.label(islands, _AROUND)
    for number, box in enumerate(scipy.ndimage.find_objects(parts), start=1):
        island = np.pad(parts[box] == number, 1)
        depth = scipy.ndimage.distance_transform_edt(island)[1:-1, 1:-1]
        edge = ridge[box] & (depth > 0.0)
        within = (depth > MARGIN) & (scipy.ndimage.distance_transform_edt(~edge) > MARGIN)
        if is_certain(strength[box][edge], strength[box][within]):
            found[box] |= edge
    return found
