"""Regions of interest and barriers of volumes, and the walls that they make, which no particle crosses.

Both are sets of voxels, each a cube around its center. A region of interest is a box, the inside of a line through
slices, or a mask; particles stay inside the cubes of all regions together. A barrier is the voxels that a plane or a
line through slices passes through, or a mask; no particle enters them.

Whether a move crosses a wall is decided exactly, by the straight line between its ends; touching counts. A particle is
never in touch with a wall, so that no speed is too high and no wall too thin. Voxels that meet along an edge or at a
corner are a wall without a gap, since a line between them touches both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.image.pyramid import to_image
from cpm_core.image.region import Region
from cpm_core.image.regions import Regions, pixels_in_polygon
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import ConnectedParts, find_connected_parts, lie_inside
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.packed_mask import PackedMask
from cpm_core.numerics.real_numbers import as_real_array, check_finite_number
from cpm_core.numerics.types import Array, Extent, Index, Line, Mask, Voxel, frozen, record
from cpm_core.numerics.vectors import Vector, row_of
from cpm_core.parameters.formatting import format_count, format_repr, format_size, quote_value

WALL_CONTACT_DISTANCE = 1e-6
"""Distance from a wall within which a position touches it [voxels]."""


@record
class Walls:
    """Walls that no particle crosses, in a volume at one of its scales.

    Attributes
    ----------
    closed : ndarray of bool, shape (P, R, C)
        Voxels of the volume, at its full size, that no particle enters.
    size : ndarray, shape (3,)
        Voxels of the volume in one unit of the positions, along each axis.
    first : ndarray, shape (3,)
        The place of the origin of the positions [voxels].
    """

    closed: Mask
    size: Array
    first: Array

    def at_scale(self, scale: int, pitch: Vector) -> Walls:
        """Return the walls for positions at a scale, in units in which a voxel has these sides."""
        ends = to_image(np.array([[0.0] * 3, [1.0] * 3]), scale, self.closed.shape)
        return replace(self, size=(ends[1] - ends[0]) / np.array(pitch), first=ends[0])

    def to_voxels(self, positions: Array) -> Array:
        """Convert positions of the scale, shape (N, 3), to voxels of the volume."""
        return positions * self.size + self.first

    def is_crossed_by(self, start: Array, end: Array) -> Mask:
        """Return whether straight moves between positions of the scale, shapes (N, 3), cross or touch a wall."""
        out = np.zeros(len(start), bool)
        if len(start):
            _mark_wall_crossings(self.closed, self.to_voxels(start), self.to_voxels(end), out)
        return out

    def find_rooms(self, positions: Array) -> Index:
        """Find the number of the room in which each position of the scale, shape (N, 3), lies; -1 in a wall.

        No move leads from one room to another. Parts of a volume that are connected, but not straight, are one room.
        """
        return self._open.part_at(self._nearest_voxels(positions))

    def find_shut_voxels(self, shape: Extent, pitch: Vector, positions: Array) -> Mask:
        """Mark the voxels of the scale, of this shape, in walls or in rooms without any of the positions (N, 3)."""
        here = self._voxels_at_scale(shape, pitch)
        return self.closed[here] | ~np.isin(self._open.labels[here] - 1, self.find_rooms(positions))

    def find_wall_voxels(self, shape: Extent, pitch: Vector) -> Mask:
        """Mark the voxels of the scale, of this shape, whose centers lie in a wall."""
        return self.closed[self._voxels_at_scale(shape, pitch)]

    def _voxels_at_scale(self, shape: Extent, pitch: Vector) -> tuple[Index, ...]:
        """Find the voxels of the volume, along each axis, nearest to the centers of those of the scale."""
        along = self._nearest_voxels(np.arange(max(shape))[:, None] * np.array(pitch))
        return np.ix_(*(along[:n, axis] for axis, n in enumerate(shape)))

    def _nearest_voxels(self, positions: Array) -> Index:
        """Find the voxel of the volume nearest to each position of the scale, shape (N, 3)."""
        voxels = np.rint(self.to_voxels(positions)).astype(np.int64)
        return np.clip(voxels, 0, np.array(self.closed.shape) - 1)

    @cached_property
    def _open(self) -> ConnectedParts:
        """Parts of the volume that are not closed; voxels with a common face are connected."""
        return find_connected_parts(~self.closed, corners=False)


@compiled
def _mark_wall_crossings(closed: Mask, start: Array, end: Array, out: Mask) -> None:
    """Mark the straight lines that meet a closed voxel."""
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for n in range(len(start)):
        a, b = row_of(start, n), row_of(end, n)
        for axis in range(3):
            last = closed.shape[axis] - 1
            low[axis] = min(max(int(np.floor(min(a[axis], b[axis]) + 0.5 - WALL_CONTACT_DISTANCE)), 0), last)
            high[axis] = min(max(int(np.floor(max(a[axis], b[axis]) + 0.5 + WALL_CONTACT_DISTANCE)), 0), last)
        for i in range(low[0], high[0] + 1):
            for j in range(low[1], high[1] + 1):
                for k in range(low[2], high[2] + 1):
                    if closed[i, j, k] and not out[n]:
                        out[n] = _meets_voxel(a, b, (float(i), float(j), float(k)))


@compiled
def _meets_voxel(a: Vector, b: Vector, center: Vector) -> bool:
    """Return whether a straight line meets the cube around a voxel."""
    begin, end = 0.0, 1.0
    for axis in range(3):
        way, off = b[axis] - a[axis], a[axis] - center[axis]
        if abs(way) < 1e-300:
            if abs(off) > 0.5 + WALL_CONTACT_DISTANCE:
                return False
            continue
        one, other = (-0.5 - WALL_CONTACT_DISTANCE - off) / way, (0.5 + WALL_CONTACT_DISTANCE - off) / way
        begin, end = max(begin, min(one, other)), min(end, max(one, other))
    return begin <= end


Pair = tuple[Voxel, Voxel]
"""Two opposite corners of a box; a point of a plane and a direction across it."""

_CACHED_REGIONS = 2
"""Number of regions whose walls are cached: several scales and steps ask for the same ones."""

_LINE_SAMPLING = 0.25
"""Distance between the places on a line by which the voxels it passes through are found [voxels]."""


@frozen
class Extrusion:
    """A line in the slices across an axis of a volume, from one of them to another.

    Attributes
    ----------
    line : tuple of tuple of float
        Corners along the two other axes, in their order [voxels].
    axis : int
        The axis across the slices: 0, 1 or 2.
    first, last : float
        Where along the axis it begins and ends [voxels].
    closed : bool
        Whether the line stands for the voxels it encloses, or for those it passes through.

    Examples
    --------
    >>> tube = cpm.Extrusion(((8.0, 8.0), (8.0, 22.0), (22.0, 22.0), (22.0, 8.0)), axis=0, first=4, last=26)
    >>> filled = np.zeros((31, 31, 31), bool)
    >>> tube.fill_into(filled)
    >>> int(filled.sum())
    4508
    """

    line: Line
    axis: int
    first: float
    last: float
    closed: bool = True

    def __post_init__(self) -> None:
        if not isinstance(self.closed, bool | np.bool_):
            raise ValueError(f"closed is {quote_value(self.closed)} but must be True or False.")
        kind = {"interest": (self.line,)} if self.closed else {"barriers": (self.line,)}
        checked = Regions(**kind)
        object.__setattr__(self, "line", (checked.interest or checked.barriers)[0])
        check_finite_number("the axis across the slices", self.axis, lambda axis: axis in (0, 1, 2), "0, 1 or 2")
        for name, place in (("first", self.first), ("last", self.last)):
            check_finite_number(f"the {name} slice of the line", place, lambda _: True, "a finite number")

    def fill_into(self, filled: Mask) -> None:
        """Mark its voxels in a volume, shape (P, R, C)."""
        slices = np.moveaxis(filled, self.axis, 0)
        begin, end = np.clip([np.ceil(self.first), np.floor(self.last) + 1], 0, len(slices)).astype(int)
        slices[begin:end] |= (pixels_in_polygon if self.closed else _pixels_on_line)(self.line, slices.shape[1:])

    def __repr__(self) -> str:
        slices = f"slices {self.first:g} to {self.last:g} across axis {self.axis}"
        return format_repr(
            "Extrusion", format_count(len(self.line), "corner"), slices, "closed" if self.closed else "open"
        )


@lru_cache(maxsize=_CACHED_REGIONS)
def _pixels_on_line(line: Line, shape: Extent) -> Mask:
    """Mark the pixels of a slice that a line passes through."""
    pixels = np.rint(polyline.resample_path(polyline.corners_of(line), _LINE_SAMPLING)).astype(np.int64)
    pixels = pixels[lie_inside(pixels, shape)]
    filled = np.zeros(shape, bool)
    filled[tuple(pixels.T)] = True
    return filled


VolumeLimit = Pair | Region | Extrusion


@frozen
class VolumeRegions:
    """Part of a volume in which particles may be: the regions of interest, cut by barriers.

    Outside the regions of interest voxels carry no fixed charge and do not count in the statistics of the edge
    strength.

    Parameters
    ----------
    interest : sequence of boxes and masks
        Each is a box, given by two opposite corners (plane, row, col) [voxels], a closed `Extrusion`, or a mask, an
        array of truth values in the shape of the volume. Without any, the whole volume is of interest.
    barriers : sequence of planes and masks
        Each is a plane, given by one of its points (plane, row, col) [voxels] and the direction across it in voxels,
        which closes the voxels that it passes through, an open `Extrusion`, or a mask of painted voxels.

    Raises
    ------
    ValueError
        For anything else, for values that are not finite, and for a direction without length.

    Examples
    --------
    >>> half = cpm.VolumeRegions(interest=[((0, 0, 0), (30, 30, 20))], barriers=[((0, 0, 15.5), (0, 0, 1))])
    >>> half
    <VolumeRegions 1 region of interest, 1 barrier>
    >>> half.check_shape((31, 31, 31))
    >>> half.contains(np.array([(15.0, 15.0, 10.0), (15.0, 15.0, 25.0)])).tolist()
    [True, False]
    >>> half.allows(np.array([(15.0, 15.0, 15.5)])).tolist(), int(half.voxel_mask((31, 31, 31)).sum())
    ([False], 20181)
    >>> half.build_walls((31, 31, 31)).closed.shape
    (31, 31, 31)
    """

    interest: tuple[VolumeLimit, ...] = ()
    barriers: tuple[VolumeLimit, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "interest", _check_limits("region of interest", "box of two corners", self.interest))
        object.__setattr__(
            self, "barriers", _check_limits("barrier", "plane of a point and a direction", self.barriers)
        )
        for number, limit in enumerate(self.barriers, start=1):
            if isinstance(limit, tuple) and not np.linalg.norm(limit[1]) > 0.0:
                raise ValueError(
                    f"the direction across barrier {number} is {quote_value(limit[1])} but must have a length above 0."
                )

    def check_shape(self, shape: Extent) -> None:
        """Raise a `ValueError` unless masks have this shape and every region of interest holds one of its voxels."""
        size = format_size(shape, "")
        if len(shape) != 3:
            raise ValueError(f"these regions are for a volume, but the image is one of {size} pixels: use Regions.")
        for noun, limits in (("region of interest", self.interest), ("barrier", self.barriers)):
            for number, limit in enumerate(limits, start=1):
                if (
                    isinstance(limit, Region)
                    and limit.pixels is not None
                    and limit.first is None
                    and limit.pixels.shape != shape
                ):
                    raise ValueError(
                        f"the mask of {noun} {number} has {format_size(limit.pixels.shape, 'voxels')} but must "
                        f"have those of the volume, {size}."
                    )
        for number, limit in enumerate(self.interest, start=1):
            if not _fill_limits((limit,), shape, _fill_box).any():
                raise ValueError(
                    f"region of interest {number} contains no voxel of the volume ({size} voxels): "
                    "place it inside the volume, around an object."
                )

    def contains(self, points: Array) -> Mask:
        """Return whether points, shape (N, 3) [voxels], lie in a region of interest, shape (N,)."""
        if not self.interest:
            return np.ones(len(points), bool)
        voxels = np.maximum(np.rint(points), 0.0).astype(np.int64)
        filled = _fill_limits(self.interest, tuple(voxels.max(axis=0, initial=0) + 1), _fill_box)
        return filled[tuple(voxels.T)]

    def allows(self, points: Array) -> Mask:
        """Return whether a particle may be at points, shape (N, 3) [voxels]: in a region of interest, off barriers."""
        places = np.maximum(points, 0.0)
        shape = np.rint(places.max(axis=0, initial=0.0)).astype(np.int64) + 2
        return ~self.build_walls(tuple(shape.tolist())).is_crossed_by(places, places)

    def voxel_mask(self, shape: Extent) -> Mask | None:
        """Mark the voxels of interest of a volume of this shape; None when all of them are."""
        return _fill_limits(self.interest, shape, _fill_box) if self.interest else None

    def build_walls(self, shape: Extent) -> Walls:
        """Build the walls that no particle crosses in a volume of this shape, at its full size."""
        return _build_walls(self, shape)

    def __repr__(self) -> str:
        interest = format_count(len(self.interest), "region of interest", "regions of interest")
        return format_repr("VolumeRegions", interest, format_count(len(self.barriers), "barrier"))


AnyRegions = Regions | VolumeRegions


def check_regions(regions: AnyRegions | None, shape: Extent) -> None:
    """Raise a `ValueError` unless regions, where there are any, fit an image or a volume of this shape."""
    if regions is None:
        return
    if not isinstance(regions, Regions | VolumeRegions):
        raise ValueError(f"regions is {quote_value(regions)} but must be Regions, or VolumeRegions in a volume.")
    regions.check_shape(shape)


@lru_cache(maxsize=_CACHED_REGIONS)
def _build_walls(regions: VolumeRegions, shape: Extent) -> Walls:
    closed = _fill_limits(regions.barriers, shape, _fill_plane)
    interest = regions.voxel_mask(shape)
    if interest is not None:
        closed |= ~interest
    return Walls(closed, np.ones(3), np.zeros(3))


def _fill_limits(limits: tuple[VolumeLimit, ...], shape: Extent, fill_pair: Callable[[Mask, Pair], None]) -> Mask:
    """Mark the voxels of a volume in limits; a pair of places is filled by `fill_pair`."""
    filled = np.zeros(shape, bool)
    for limit in limits:
        if isinstance(limit, tuple):
            fill_pair(filled, limit)
        else:
            limit.fill_into(filled)
    return filled


def _fill_box(filled: Mask, corners: Pair) -> None:
    """Mark the voxels whose centers lie in a box."""
    low, high = np.sort(corners, axis=0)
    first = np.clip(np.ceil(low), 0, filled.shape).astype(int)
    last = np.clip(np.floor(high) + 1, 0, filled.shape).astype(int)
    filled[tuple(map(slice, first, last))] = True


def _fill_plane(filled: Mask, plane: Pair) -> None:
    """Mark the voxels that a plane through a point, across a direction, passes through."""
    point, normal = np.array(plane)
    along = np.meshgrid(
        *(np.arange(n) - at for n, at in zip(filled.shape, point, strict=True)), indexing="ij", sparse=True
    )
    distance = sum(size * place for size, place in zip(normal, along, strict=True))
    filled |= np.abs(distance) <= 0.5 * np.abs(normal).sum()


def _check_limits(noun: str, form: str, given: Any) -> tuple[VolumeLimit, ...]:
    """Check limits, and convert them to pairs of places and to voxels."""
    if isinstance(given, np.ndarray) or not isinstance(given, Iterable):
        raise ValueError(
            f"the limits of one kind must be a list, not {quote_value(given)}: give a list of every {noun}."
        )
    return tuple(_check_limit(f"{noun} {number}", form, limit) for number, limit in enumerate(given, start=1))


def _check_limit(what: str, form: str, given: ArrayLike | Region | Extrusion) -> VolumeLimit:
    if isinstance(given, Region | Extrusion):
        return given
    try:
        array = np.asarray(given)
        if array.dtype == np.bool_ and array.ndim == 3:
            return Region(pixels=PackedMask.pack(array))
        pair = as_real_array(array)
    except (TypeError, ValueError):
        pair = np.zeros(0)
    if pair.shape != (2, 3) or np.asarray(given).dtype == np.bool_:
        raise ValueError(
            f"{what} must be a {form}, each (plane, row, col), or a mask of truth values in the shape of the volume."
        )
    if not np.isfinite(pair).all():
        raise ValueError(f"{what} has coordinates that are not finite: give numbers of planes, rows and columns.")
    return tuple(map(tuple, pair.tolist()))  # type: ignore[return-value]


def plane_regions(regions: AnyRegions | None) -> Regions | None:
    """Return the regions of an image; None for those of a volume."""
    return regions if isinstance(regions, Regions) else None
