"""Regions: what is found in an image or a volume, as pixels in a box, within an exact boundary where one is known."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Self

import numpy as np
import scipy

from cpm_core.image.surface import Surface, voxelize_surface
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import (
    Window,
    bounding_window,
    enclose_windows,
    relative_window,
    true_bounds,
    window_shape,
    zero_surface,
)
from cpm_core.numerics.types import Array, Extent, Index, Integers, Line, Mask, Place, record

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
        The closed surface around a region of a volume [voxels]; None where only the voxels are known.
    pixels : ndarray of bool or None
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
    pixels: Mask | None = None
    first: Integers | None = None

    def __post_init__(self) -> None:
        if self.pixels is not None:
            pixels = np.array(self.pixels, bool, order="C")
            pixels.flags.writeable = False
            object.__setattr__(self, "pixels", pixels)
        elif self.surface is not None:
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
            pixels=mask[window], first=tuple(int(at) + side.start for at, side in zip(begin, window, strict=True))
        )

    @classmethod
    def from_pixels(cls, pixels: Index) -> Self:
        """Make the region of some pixels, shape (N, D)."""
        if not len(pixels):
            return cls(pixels=np.zeros((0,) * pixels.shape[1], bool))
        first = pixels.min(axis=0)
        mask = np.zeros(pixels.max(axis=0) + 1 - first, bool)
        mask[tuple((pixels - first).T)] = True
        return cls(pixels=mask, first=tuple(first.tolist()))

    @classmethod
    def from_surface(cls, surface: Surface) -> Self:
        """Make the region inside a surface, in the single precision that sessions keep."""
        return cls(surface=Surface(surface.vertices.astype(np.float32), surface.faces))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Region) or (self.boundary, self.first) != (other.boundary, other.first):
            return False
        if (self.pixels is None, self.surface is None) != (other.pixels is None, other.surface is None):
            return False
        if self.pixels is not other.pixels and not np.array_equal(self.pixels, other.pixels):  # type: ignore[arg-type]
            return False
        one, two = self.surface, other.surface
        return one is two or (
            one is not None and two is not None
            and np.array_equal(one.vertices, two.vertices) and np.array_equal(one.faces, two.faces)
        )  # fmt: skip

    def __hash__(self) -> int:
        size = None if self.pixels is None else (self.pixels.shape, self.size)  # painted versions of an object differ
        count = None if self.surface is None else len(self.surface.faces)
        return hash((len(self.boundary), self.boundary[:1] and self.boundary[0][:2], count, self.first, size))

    # Pixels

    @property
    def ndim(self) -> int:
        """Number of axes: 2, or 3 in a volume."""
        return self.pixels.ndim if self.pixels is not None else 2 if self.surface is None else 3

    @property
    def is_empty(self) -> bool:
        """Whether nothing is inside."""
        return not (self.boundary or self.surface or (self.pixels is not None and self.pixels.any()))

    @property
    def origin(self) -> Integers:
        """The pixel of the image that `mask` begins at."""
        return self._box[0]

    @property
    def mask(self) -> Mask:
        """The pixels in a box around them."""
        return self._box[1]

    @cached_property
    def _box(self) -> tuple[Integers, Mask]:
        if self.pixels is not None:
            return self.first or (0,) * self.pixels.ndim, self.pixels
        if not self.boundary and self.surface is None:
            return (0, 0), np.zeros((0, 0), bool)
        low, high = self.bounds
        first, end = np.floor(low).astype(np.int64) - 1, np.ceil(high).astype(np.int64) + 2
        if self.surface is None:
            return self.cut_to(tuple(first.tolist()), tuple(end.tolist()))
        there = replace(self.surface, vertices=self.surface.vertices - first)
        return tuple(first.tolist()), voxelize_surface(there, tuple((end - first).tolist()))

    def cut_to(self, begin: Corner, end: Corner) -> tuple[Integers, Mask]:
        """Return the pixels from a corner up to another: those in a box, and the first pixel of the box.

        Boundaries may reach far beyond the image.
        """
        if self.boundary and self.pixels is None:
            low, high = self.bounds
            first = np.clip(np.floor(low), begin, end).astype(int)
            last = np.clip(np.ceil(high) + 1, first, end).astype(int)
            return tuple(first.tolist()), self._rasterize(tuple(first.tolist()), tuple(last.tolist()))
        origin, mask = self._box
        first = np.clip(origin, begin, end)
        last = np.clip(np.add(origin, mask.shape), first, np.maximum(first, end))
        there = tuple(map(slice, np.minimum(first - origin, mask.shape), np.minimum(last - origin, mask.shape)))
        return tuple(first.tolist()), mask[there]

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
            places = np.stack(np.meshgrid(rows[top : top + height], cols, indexing="ij"), axis=-1).reshape(-1, 2)
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
        return tuple(slice(at, at + side) for at, side in zip(self.origin, self.mask.shape, strict=True))

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
        filled[tuple(slice(at, at + n) for at, n in zip(first, mask.shape, strict=True))] |= mask

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
        at = np.rint(places).astype(np.int64) - self.origin
        there = ((at >= 0) & (at < self.mask.shape)).all(axis=1)
        found[there] = self.mask[tuple(at[there].T)]
        return found

    def contains(self, place: Place) -> bool:
        """Return whether a point lies inside; see `encloses`."""
        return bool(self.encloses(np.array([place], float))[0])

    def _find_overlap(self, other: Region) -> tuple[Window, Mask]:
        """Find the part of the box of this region in which another lies, and the pixels of the other there."""
        first, mask = other.cut_to(self.origin, np.add(self.origin, self.mask.shape))
        return tuple(slice(at - b, at - b + n) for at, b, n in zip(first, self.origin, mask.shape, strict=True)), mask

    def united(self, other: Region) -> Region:
        """Return the pixels of this region and of another."""
        window = enclose_windows(self.window, other.window)
        found = np.zeros(window_shape(window), bool)
        for one in (self, other):
            found[relative_window(one.window, window)] |= one.mask
        return Region.from_mask(found, [side.start for side in window])

    def without(self, other: Region) -> Region:
        """Return the pixels of this region that are not those of another."""
        there, taken = self._find_overlap(other)
        left = self.mask.copy()
        left[there] &= ~taken
        return Region.from_mask(left, self.origin)

    def shared_with(self, other: Region) -> Region:
        """Return the pixels that this region has in common with another."""
        there, mask = self._find_overlap(other)
        return Region.from_mask(self.mask[there] & mask, np.add(self.origin, [side.start for side in there]))

    def count_shared(self, other: Region) -> int:
        """Count the pixels that this region has in common with another."""
        there, mask = self._find_overlap(other)
        return int(np.count_nonzero(self.mask[there] & mask))

    def compute_iou(self, other: Region) -> float:
        """Compute the overlap (intersection over union) with another region; 0 when both are empty."""
        both = self.count_shared(other)
        whole = np.count_nonzero(self.mask) + np.count_nonzero(other.mask) - both
        return both / whole if whole else 0.0

    @cached_property
    def filled(self) -> Region:
        """The region with its holes."""
        return Region(pixels=scipy.ndimage.binary_fill_holes(self.mask), first=self.origin)

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
        depth = scipy.ndimage.distance_transform_edt(np.pad(mask, 1))[1:-1, 1:-1]
        row, col = np.unravel_index(int(np.argmax(depth)), mask.shape)
        return (*plane, float(row + first[0]), float(col + first[1]))

    # Boundary

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lowest and highest position along each axis of the boundary, or else of the pixels, each of shape (D,)."""
        if self.pixels is not None:
            low, high = true_bounds(self.pixels).astype(float) + (self.first or 0)
            return low, high
        corners = np.concatenate(self.boundary) if self.surface is None else self.surface.vertices
        return corners.min(axis=0), corners.max(axis=0)

    @property
    def outer_curves(self) -> tuple[Line, ...]:
        """The curves of the boundary that do not bound holes."""
        if len(self.boundary) == 1:
            return self.boundary
        around = [
            sum(
                bool(polyline.points_inside(other, np.array(curve[:1]))[0])
                for other in self.boundary
                if other is not curve
            )
            for curve in self.boundary
        ]
        return tuple(curve for curve, count in zip(self.boundary, around, strict=True) if count % 2 == 0)

    @cached_property
    def size(self) -> float:
        """Area without holes [px²], or volume [voxels]: within the boundary, or else of the pixels."""
        if self.pixels is not None:
            return float(np.count_nonzero(self.pixels))
        if self.surface is not None:
            return self.surface.volume
        outer = self.outer_curves
        return float(sum(polyline.enclosed_area(curve) * (1.0 if curve in outer else -1.0) for curve in self.boundary))

    def find_surface(self) -> Surface:
        """Return the surface around a region of a volume [voxels]: where only voxels are known, around exactly them."""
        return self.surface or _build_surface(self)

    def translated(self, offset: Place) -> Region:
        """Return the region displaced along each axis of a volume; voxels to the nearest whole one."""
        if self.surface is not None:
            return Region.from_surface(replace(self.surface, vertices=self.surface.vertices + np.array(offset)))
        return Region.from_mask(self.mask, np.rint(np.add(self.origin, offset)).astype(int))


_VOXEL_SMOOTHING = 0.8
"""Standard deviation that smooths the steps between voxels for a surface [voxels]."""

_SURFACE_MARGIN = 3
"""Empty voxels added on all sides before a surface is built [voxels]."""

_MIN_LEVEL_OFFSET = 0.15
"""Least difference of a smoothed voxel from the level of the surface, so that it stays on its side."""

_PLANES_PER_PIECE = 16
"""Planes of a surface that are built at once: meanwhile the interpreter does nothing else."""

_CACHED_SURFACES = 32
"""Number of regions whose surfaces are cached: an undo stack holds many versions of each."""


@lru_cache(maxsize=_CACHED_SURFACES)
def _build_surface(region: Region) -> Surface:
    inside = np.pad(region.mask, _SURFACE_MARGIN)
    level = scipy.ndimage.gaussian_filter(inside.astype(np.float32), _VOXEL_SMOOTHING) - np.float32(0.5)
    level = np.where(inside, np.maximum(level, _MIN_LEVEL_OFFSET), np.minimum(level, -_MIN_LEVEL_OFFSET))
    # a few planes at a time, so that the window gets its turn; vertices on the planes between occur twice
    ends = pairwise([*range(0, len(level) - 1, _PLANES_PER_PIECE), len(level) - 1])
    inner = [(0, side) for side in level.shape[1:]]
    parts = [zero_surface(level, ((first, last + 1), *inner)) for first, last in ends]
    counts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    vertices = np.concatenate([part for part, _ in parts])
    faces = np.concatenate([part + count for (_, part), count in zip(parts, counts, strict=False)])
    order = np.lexsort(vertices.T)  # much faster than np.unique(axis=0)
    ordered = vertices[order]
    is_new = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))
    numbers = np.empty(len(order), np.int64)
    numbers[order] = np.cumsum(is_new) - 1
    return Surface(ordered[is_new] + np.array(region.origin) - _SURFACE_MARGIN, numbers[faces])
