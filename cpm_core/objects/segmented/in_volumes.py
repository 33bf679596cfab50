"""Objects in a volume edited by hand: brushes, painting, filling between painted slices, splitting."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
import scipy

from cpm_core.image.region import Region
from cpm_core.numerics.grids import flood_from_markers, label_parts, nearest_pixels, spread_labels
from cpm_core.numerics.types import Array, Extent, Mask, Place, Sides
from cpm_core.objects.segmented.by_hand import POINT_OUTSIDE, Halves, climb_to_peak
from cpm_core.objects.segmented.segmented_object import SegmentedObject, SegmentedObjects

_MAX_RIPPLE_HEIGHT = 0.01
"""Largest height of a ripple along the path of a brush, which consists of balls [smallest sides of a voxel]."""


def voxelize_brush(
    shape: Extent, path: Sequence[Place], radius: float, sides: Sides, axis: int | None = None
) -> Region:
    """Find the voxels of a volume that a brush covers on the way between two places, or at one.

    Parameters
    ----------
    shape : tuple of int
        Shape of the volume.
    path : sequence of (plane, row, col)
        One place, or two [voxels]; the voxel of the last one is always covered.
    radius : float
        Radius of the brush, in sides of the smallest voxel.
    sides : tuple of float
        Sides of a voxel, in units of the smallest.
    axis : int, optional
        The axis across which the slice lies that the brush stays in; by default it is a ball.
    """
    ends, size = np.array(path, dtype=float), np.array(sides)
    reach = radius / size
    if axis is not None:
        reach[axis] = 0.0
    last = nearest_pixels(ends[-1], shape)
    low = np.minimum(np.clip(np.ceil(ends.min(axis=0) - reach), 0, shape).astype(np.int64), last)
    high = np.maximum(np.clip(np.floor(ends.max(axis=0) + reach) + 1, 0, shape).astype(np.int64), last + 1)
    plane, row, col = (np.arange(a, b) * side for a, b, side in zip(low, high, sides, strict=True))
    # a brush is convex, so that on each row it covers the voxels between two columns
    first, behind = (np.full((len(plane), len(row)), end) for end in (np.inf, -np.inf))
    count = 1 + math.ceil(
        float(np.linalg.norm((ends[-1] - ends[0]) * size)) / math.sqrt(8.0 * radius * _MAX_RIPPLE_HEIGHT)
    )
    for at in np.linspace(ends[0], ends[-1], count) * size:
        square = radius**2 - (plane[:, None] - at[0]) ** 2 - (row - at[1]) ** 2
        half = np.sqrt(np.where(square >= 0.0, square, np.nan))
        first, behind = np.fmin(first, at[2] - half), np.fmax(behind, at[2] + half)
    mask = (col >= first[..., None]) & (col <= behind[..., None])
    mask[tuple(last - low)] = True
    return Region.from_mask(mask, low)


def paint_voxels(objects: SegmentedObjects, number: int, part: Region, adds: bool = True) -> SegmentedObjects:
    """Add voxels to one of the objects of a volume, or remove them; an object without any left is dropped.

    Surfaces stay where nothing is painted. Voxels of other objects are not added, or, if objects may overlap, taken
    from those that are not frozen or hidden.

    Parameters
    ----------
    objects : SegmentedObjects
        Objects of a volume.
    number : int
        Number of an object, or of a new one, which gets the class of the next object.
    part : Region
        The voxels.
    adds : bool
        Whether they are added rather than removed.
    """
    known = {item.number: item for item in objects.items}
    others = [item for item in objects.items if adds and item.number != number]
    yielding = [item for item in others if objects.may_overlap and not item.frozen and not item.hidden]
    for item in others:
        if item not in yielding:
            part = part.without(item.region)
    touched = (item for item in yielding if item.region.count_shared(part))
    painted = {item.number: item.region.without(part) for item in touched}
    if number in known:
        before = known[number].region
        painted[number] = before.united(part) if adds else before.without(part)
    elif adds and not part.is_empty:
        known[number] = SegmentedObject(number, (), part, category=objects.category)
    for other, region in painted.items():
        if region.is_empty:
            del known[other]
        elif region.count != known[other].region.count:
            known[other] = known[other].redrawn(region)
    ends = replace(objects, clicks=(), edited=0) if objects.edited in painted else objects
    return replace(ends, items=tuple(known.values()))


def split_painted_object(item: SegmentedObject, first: Place, second: Place, sides: Sides) -> Halves:
    """Split a painted object of a volume into two, each with one of two points.

    They meet at the neck between the points, by the watershed of the distance from the boundary, or halfway without a
    neck. `sides` are those of a voxel. ValueError when a point lies outside.
    """
    inside, begin = np.pad(item.region.mask, 1), np.array(item.region.origin) - 1
    if not item.region.encloses(np.array([first, second], float)).all():
        raise ValueError(POINT_OUTSIDE)
    places = [np.rint(place).astype(np.int64) - begin for place in (first, second)]
    depth = scipy.ndimage.distance_transform_edt(inside, sampling=sides)
    height = -scipy.ndimage.gaussian_filter(depth, 1.0)
    ways = [climb_to_peak(-height, place) for place in places]
    if (ways[0][-1] == ways[1][-1]).all():
        ways, height = [[place] for place in places], np.zeros_like(height)
    seeds = np.zeros(inside.shape, np.int32)
    for number, way in enumerate(ways, start=1):
        seeds[tuple(np.transpose(way))] = number
    found = flood_from_markers(height, seeds, inside)
    found = np.where(inside, spread_labels(found), 0)  # assign pieces that are connected to neither point
    halves = [Region.from_mask(found == number, begin) for number in (1, 2)]
    one, other = (item.redrawn(item.region.without(half)) for half in reversed(halves))
    return Halves(one, other, ())


def fill_between_slices(body: Region, axis: int, sides: Sides) -> tuple[Region, int]:
    """Find the voxels between slices of a body across an axis; also return the number of slices that get some.

    Signed distances from the outlines are interpolated (S. P. Raya and J. K. Udupa, 1990) between the pieces of two
    slices that overlap, or that are nearest where none does, with their centers on each other, so that slanted pieces
    keep their width (G. T. Herman, J. Zheng and C. A. Bucholtz, 1992). `sides` are those of a voxel.
    """
    slices = np.moveaxis(body.mask, axis, 0)
    filled = np.zeros_like(slices)
    pixel = sides[:axis] + sides[axis + 1 :]
    for first, last in pairwise(np.flatnonzero(slices.any(axis=(1, 2))).tolist()):
        pairs = _match_pieces(slices[first], slices[last], pixel) if last - first > 1 else ()
        for at in range(first + 1, last):
            share = (at - first) / (last - first)
            filled[at] = np.any([_interpolate_pieces(*pair, pixel, share) for pair in pairs], axis=0)
    return Region.from_mask(np.moveaxis(filled, 0, axis), body.origin), int(filled.any(axis=(1, 2)).sum())


def _interpolate_pieces(one: Mask, other: Mask, pixel: tuple[float, ...], share: float) -> Mask:
    """Interpolate two pieces at a fraction of the way from one to the other."""
    way = _find_center(other) - _find_center(one)
    margin = math.ceil(np.abs(way).max())  # as far as the pieces are shifted
    near, far = (
        weight * scipy.ndimage.shift(_signed_piece_distance(np.pad(piece, margin), pixel), by * way, order=1)
        for piece, weight, by in ((one, 1.0 - share, share), (other, share, share - 1.0))
    )
    return np.asarray(near + far > 0.0)[tuple(slice(margin, margin + side) for side in one.shape)]


def _match_pieces(first: Mask, last: Mask, pixel: tuple[float, ...]) -> list[tuple[Mask, Mask]]:
    """Match the pieces of two slices that continue each other: those that overlap, or else the nearest ones."""
    one, other = ([numbers == n for n in range(1, count + 1)] for numbers, count in map(label_parts, (first, last)))
    meet = np.array([[(a & b).any() for b in other] for a in one])
    away = np.array([[np.linalg.norm((_find_center(a) - _find_center(b)) * pixel) for b in other] for a in one])
    for joined, distances in ((meet, away), (meet.T, away.T)):
        alone = ~joined.any(axis=1)
        joined[alone, distances.argmin(axis=1)[alone]] = True
    return [(one[i], other[j]) for i, j in np.argwhere(meet).tolist()]


def _find_center(piece: Mask) -> Array:
    return np.argwhere(piece).mean(axis=0)


def _signed_piece_distance(piece: Mask, pixel: tuple[float, ...]) -> Array:
    """Compute the distance from the outline of a piece, negative outside."""
    inside, outside = (
        scipy.ndimage.distance_transform_edt(np.pad(each, 1, constant_values=not within), sampling=pixel)
        for each, within in ((piece, True), (~piece, False))
    )
    return np.asarray(inside - outside)[1:-1, 1:-1]
