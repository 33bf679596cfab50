"""Regions: what is found in an image or a volume, as pixels in a box, within an exact boundary where one is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import Self

import numpy as np
import scipy

from cpm_core.image.surface import Surface, voxelize_surface
from cpm_core.image.voxel_surface import follow_painted_voxels, surround_voxels
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import (
    Window,
    bounding_window,
    enclose_windows,
    first_pixel,
    grid_points,
    lie_inside,
    measure_depth,
    relative_window,
    true_bounds,
    window_at,
    window_shape,
)
from cpm_core.numerics.packed_mask import PackedMask
from cpm_core.numerics.types import Array, Extent, Index, Integers, Line, Mask, Place, record
from cpm_core.numerics.weak_cache import WeakCache

MAX_BOX_VOXELS = 2**28
"""Largest box around a surface [voxels]; filling it takes at least one byte per voxel."""

_PIXELS_PER_TEST = 2**20
"""Pixels that are tested at once, so that a large image takes little memory."""

Corner = Sequence[int] | Index
"""A pixel or a voxel, or the sides of a box."""


@record
class Region:
    """A set of pixels of an image, or of voxels of a volume; equal to others of the same pixels and boundary.

    Its boundary is kept where it is known to a fraction of a pixel. Otherwise it is derived from the pixels.

    Attributes
    ----------
    boundary : tuple of tuple
        Closed curves of vertices (row, col) in px of the image, the first vertex not repeated: outer boundaries and
        holes. A place is inside when an odd number of them encloses it. Empty where only the pixels are known, and in a
        volume.
    surface : Surface or None
        The closed surface around a region of a volume [voxels]; None where only the voxels are known. Where other
        voxels have been painted than lie inside, it is to follow these (`find_surface`).
    pixels : PackedMask or None
        The pixels in a box; None for all whose centers lie inside the boundary or the surface.
    first : tuple of int or None
        The pixel of the image that this box begins at, which may lie outside; None for a box that is the whole image.

    Raises
    ------
    ValueError
        When a surface is not closed, or far too large.
    """

    boundary: tuple[Line, ...] = ()
    surface: Surface | None = None
    pixels: PackedMask | None = None
    first: Integers | None = None

    def __post_init__(self) -> None:
        if self.surface is not None:
            if not self.surface.closed:
                raise ValueError("The surface around an object is not closed, so nothing is inside.")
            sides = np.ceil(np.ptp(self.surface.vertices, axis=0)).tolist()
            if math.prod(sides) > MAX_BOX_VOXELS:
                raise ValueError(
                    f"The surface around an object spans {' x '.join(f'{side:g}' for side in sides)} voxels, but at "
                    f"most {MAX_BOX_VOXELS:,} in all can be filled: make it smaller."
                )

    @classmethod
    def from_mask(cls, mask: Mask, first: Corner | None = None) -> Self:
        """Make the region of the true pixels of a mask that begins at a pixel, by default the first of the image."""
        window = bounding_window(mask) if mask.any() else (slice(0, 0),) * mask.ndim
        begin = [0] * mask.ndim if first is None else first
        return cls(
            pixels=PackedMask.pack(mask[window]),
            first=tuple(int(at) + side.start for at, side in zip(begin, window, strict=True)),
        )

    @classmethod
    def from_pixels(cls, pixels: Index) -> Self:
        """Make the region of some pixels, shape (N, D)."""
        if not len(pixels):
            return cls(pixels=PackedMask.pack(np.zeros((0,) * pixels.shape[1], bool)))
        first = pixels.min(axis=0)
        mask = np.zeros(pixels.max(axis=0) + 1 - first, bool)
        mask[tuple((pixels - first).T)] = True
        return cls(pixels=PackedMask.pack(mask), first=tuple(first.tolist()))

    @classmethod
    def from_surface(cls, surface: Surface) -> Self:
        """Make the region inside a surface, in the single precision that sessions keep."""
        return cls(surface=Surface(surface.vertices.astype(np.float32), surface.faces))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Region):
            return False
        if (self.boundary, self.first, self.pixels) != (other.boundary, other.first, other.pixels):
            return False
        one, two = self.surface, other.surface
        return one is two or (
            one is not None and two is not None
            and np.array_equal(one.vertices, two.vertices) and np.array_equal(one.faces, two.faces)
        )  # fmt: skip

    def __hash__(self) -> int:
        count = None if self.surface is None else len(self.surface.faces)
        return hash((len(self.boundary), self.boundary[:1] and self.boundary[0][:2], count, self.first, self.pixels))

    # Pixels

    @property
    def ndim(self) -> int:
        """Number of axes: 2, or 3 in a volume."""
        return len(self.pixels.shape) if self.pixels is not None else 2 if self.surface is None else 3

    @property
    def is_empty(self) -> bool:
        """Whether nothing is inside."""
        return not (self.boundary or self.surface) if self.pixels is None else not self.pixels.count

    @cached_property
    def count(self) -> int:
        """Number of pixels."""
        return self._box[1].count

    @property
    def origin(self) -> Integers:
        """The pixel of the image that `mask` begins at."""
        return self._box[0]

    @property
    def mask(self) -> Mask:
        """The pixels in a box around them, unpacked."""
        return self._box[1].unpack()

    @cached_property
    def _box(self) -> tuple[Integers, PackedMask]:
        if self.pixels is not None:
            return self.first or (0,) * self.ndim, self.pixels
        if not self.boundary and self.surface is None:
            return (0, 0), PackedMask.pack(np.zeros((0, 0), bool))
        if self.surface is not None:
            return _FILLED_SURFACES.get(_fill_surface, self.surface)
        low, high = self.bounds
        first, end = np.floor(low).astype(int) - 1, np.ceil(high).astype(int) + 2
        begin, mask = self.cut_to(tuple(first.tolist()), tuple(end.tolist()))
        return begin, PackedMask.pack(mask)

    def cut_to(self, begin: Corner, end: Corner) -> tuple[Integers, Mask]:
        """Return the pixels from a corner up to another: those in a box, and the first pixel of the box.

        Boundaries may reach far beyond the image.
        """
        if self.boundary and self.pixels is None:
            low, high = self.bounds
            first = np.clip(np.floor(low), begin, end).astype(int)
            last = np.clip(np.ceil(high) + 1, first, end).astype(int)
            return tuple(first.tolist()), self._rasterize(tuple(first.tolist()), tuple(last.tolist()))
        origin, packed = self._box
        corner: list[int] = []
        window: list[slice] = []
        for at, side, lowest, highest in zip(origin, packed.shape, begin, end, strict=True):  # arrays would be slower
            start = min(max(at, int(lowest)), int(highest))
            stop = max(min(at + side, int(highest)), start)
            corner.append(start)
            window.append(slice(min(start - at, side), min(stop - at, side)))
        return tuple(corner), packed.cut(tuple(window))

    def _rasterize(self, first: Integers, last: Integers) -> Mask:
        """Mark the pixels of a box inside the boundary; those of the last box are kept, as each click needs them."""
        known = self._rasterized.get((first, last))
        if known is not None:
            return known
        rows, cols = np.arange(first[0], last[0]), np.arange(first[1], last[1])
        mask = np.zeros((len(rows), len(cols)), bool)
        height = max(1, _PIXELS_PER_TEST // max(1, len(cols)))
        for top in range(0, len(rows), height):
            part = mask[top : top + height]
            places = grid_points((rows[top : top + height], cols))
            part[:] = self.encloses(places.astype(float)).reshape(part.shape)
        self._rasterized.clear()
        self._rasterized[first, last] = mask
        return mask

    @cached_property
    def _rasterized(self) -> dict[tuple[Integers, Integers], Mask]:
        return {}

    @property
    def window(self) -> Window:
        """Rows and columns of the box around the pixels."""
        return window_at(self.origin, self._box[1].shape)

    def cut_out(self, window: Window) -> Mask:
        """Return the pixels in a window, which may begin outside the image."""
        found = np.zeros(window_shape(window), bool)
        begin, end = zip(*((side.start, side.stop) for side in window), strict=True)
        first, mask = self.cut_to(begin, end)
        found[tuple(slice(a - b, a - b + n) for a, b, n in zip(first, begin, mask.shape, strict=True))] = mask
        return found

    def fill_into(self, filled: Mask) -> None:
        """Mark the pixels in a mask of the image."""
        first, mask = self.cut_to((0,) * filled.ndim, filled.shape)
        filled[window_at(first, mask.shape)] |= mask

    def clipped(self, shape: Extent) -> Region:
        """Return the pixels that lie in an image of this shape."""
        first, mask = self.cut_to((0,) * len(shape), shape)
        return Region.from_mask(mask, first)

    def paste(self, shape: Extent) -> Mask:
        """Return the pixels as a mask of an image of this shape."""
        found = np.zeros(shape, bool)
        self.fill_into(found)
        return found

    def encloses(self, places: Array) -> Mask:
        """Return which points, shape (N, D) [px], lie inside, shape (N,): their pixels, where only these are known."""
        found = np.zeros(len(places), bool)
        if self.pixels is None and self.surface is None:
            for curve in self.boundary:
                found ^= polyline.points_inside(curve, places)
            return found
        origin, packed = self._box
        at = np.rint(places).astype(np.int64) - origin
        there = lie_inside(at, packed.shape)
        if there.any():
            low, high = at[there].min(axis=0), at[there].max(axis=0) + 1
            near = packed.cut(tuple(map(slice, low.tolist(), high.tolist())))
            found[there] = near[tuple((at[there] - low).T)]
        return found

    def contains(self, place: Place) -> bool:
        """Return whether a point lies inside; see `encloses`."""
        return bool(self.encloses(np.array([place], float))[0])

    def _find_overlap(self, other: Region) -> tuple[Window, Mask]:
        """Find the part of the box of this region in which another lies, and the pixels of the other there."""
        first, mask = other.cut_to(self.origin, [side.stop for side in self.window])
        return tuple(slice(at - b, at - b + n) for at, b, n in zip(first, self.origin, mask.shape, strict=True)), mask

    def united(self, other: Region) -> Region:
        """Return the pixels of this region and of another; its surface stays, where it has one."""
        window = enclose_windows(self.window, other.window)
        if window == self.window:
            return self._changed(other, adds=True)
        found = np.zeros(window_shape(window), bool)
        for one in (self, other):
            found[relative_window(one.window, window)] |= one.mask
        return replace(Region.from_mask(found, first_pixel(window)), surface=self.surface)

    def without(self, other: Region) -> Region:
        """Return the pixels of this region that are not those of another; its surface stays, where it has one."""
        left = self._changed(other, adds=False)
        if (left.pixels is not None and left.pixels.is_tight) or left.is_empty:
            return left
        return replace(Region.from_mask(left.mask, left.origin), surface=left.surface)

    def _changed(self, other: Region, adds: bool) -> Region:
        """Return the region with the pixels of another in its box added or removed."""
        origin, packed = self._box
        there, mask = self._find_overlap(other)
        return Region(surface=self.surface, pixels=packed.changed(there, mask, adds), first=origin)

    def shared_with(self, other: Region) -> Region:
        """Return the pixels that this region has in common with another."""
        there, mask = self._find_overlap(other)
        return Region.from_mask(self._box[1].cut(there) & mask, np.add(self.origin, first_pixel(there)))

    def count_shared(self, other: Region) -> int:
        """Count the pixels that this region has in common with another."""
        sides = zip(self.window, other.window, strict=True)
        if any(one.stop <= two.start or two.stop <= one.start for one, two in sides):
            return 0
        there, mask = self._find_overlap(other)
        return int(np.count_nonzero(self._box[1].cut(there) & mask))

    def compute_iou(self, other: Region) -> float:
        """Compute the overlap (intersection over union) with another region; 0 when both are empty."""
        both = self.count_shared(other)
        whole = self.count + other.count - both
        return both / whole if whole else 0.0

    @cached_property
    def filled(self) -> Region:
        """The region with its holes."""
        return Region(pixels=PackedMask.pack(scipy.ndimage.binary_fill_holes(self.mask)), first=self.origin)

    @cached_property
    def shell(self) -> Region:
        """Pixels that share a side with one outside."""
        return Region.from_mask(self.mask & ~scipy.ndimage.binary_erosion(self.mask), self.origin)

    def find_innermost_pixel(self, shape: Extent) -> Place:
        """Find the pixel inside that is farthest from the boundary and from the border of the image.

        A vertex when no pixel lies inside; in a volume the innermost pixel of the plane with most voxels.
        """
        first, mask = self.cut_to((0,) * len(shape), shape)
        if not mask.any():
            return self.boundary[0][0] if self.boundary else tuple(self.find_surface().vertices[0].tolist())
        plane: Place = ()
        if mask.ndim == 3:
            at = int(mask.sum(axis=(1, 2)).argmax())
            plane, first, mask = (float(first[0] + at),), first[1:], mask[at]
        depth = measure_depth(mask)
        row, col = np.unravel_index(int(np.argmax(depth)), mask.shape)
        return (*plane, float(row + first[0]), float(col + first[1]))

    # Boundary

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest position along each axis of the boundary, or else of the pixels, each of shape (D,)."""
        if self.pixels is not None:
            low, high = true_bounds(self.pixels.unpack()).astype(float) + (self.first or 0)
            return low, high
        corners = np.concatenate(self.boundary) if self.surface is None else self.surface.vertices
        return corners.min(axis=0), corners.max(axis=0)

    @property
    def outer_curves(self) -> tuple[Line, ...]:
        """The curves of the boundary that do not bound holes."""
        holes = polyline.find_holes(self.boundary)
        return tuple(curve for curve, hole in zip(self.boundary, holes, strict=True) if not hole)

    @cached_property
    def size(self) -> float:
        """Area without holes [px²], or volume [voxels]: within the boundary, or else of the pixels."""
        if self.pixels is not None:
            return float(self.count)
        if self.surface is not None:
            return self.surface.volume
        outer = self.outer_curves
        return float(sum(polyline.enclosed_area(curve) * (1.0 if curve in outer else -1.0) for curve in self.boundary))

    @property
    def unpainted(self) -> Region:
        """What the surface encloses; without one the region itself."""
        return self if self.surface is None else Region(surface=self.surface)

    def find_surface(self) -> Surface:
        """Return the surface around a region of a volume [voxels].

        Where it is known, it is the same to the bit but near voxels that were painted; else it runs around exactly the
        voxels.
        """
        if self.surface is not None and self.pixels is None:
            return self.surface
        return _BUILT_SURFACES.get(_build_surface, self)

    def translated(self, offset: Place) -> Region:
        """Return the region displaced along each axis of a volume; painted voxels to the nearest whole one."""
        if self.surface is not None and self.pixels is None:
            return Region.from_surface(replace(self.surface, vertices=self.surface.vertices + np.array(offset)))
        return Region.from_mask(self.mask, np.rint(np.add(self.origin, offset)).astype(int))


_BUILT_SURFACES = WeakCache[Surface](8)
"""The surfaces of painted regions that were asked for last."""


def _build_surface(region: Region) -> Surface:
    """Build the surface around voxels, near those that were painted if there was one."""
    if region.surface is None:
        return surround_voxels(region.mask, region.origin)
    window = enclose_windows(region.window, region.unpainted.window)
    before, after = (one.cut_out(window) for one in (region.unpainted, region))
    return follow_painted_voxels(region.surface, before, after, tuple(side.start for side in window))


_FILLED_SURFACES = WeakCache[tuple[Integers, PackedMask]](256)
"""The voxels inside surfaces, which all painted versions of a region share."""


def _fill_surface(surface: Surface) -> tuple[Integers, PackedMask]:
    """Mark the voxels inside a surface in a box; return its first voxel, too."""
    first = np.floor(surface.vertices.min(axis=0)).astype(np.int64) - 1
    end = np.ceil(surface.vertices.max(axis=0)).astype(np.int64) + 2
    there = replace(surface, vertices=surface.vertices - first)
    return tuple(first.tolist()), PackedMask.pack(voxelize_surface(there, tuple((end - first).tolist())))
