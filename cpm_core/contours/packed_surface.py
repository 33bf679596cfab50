"""Bodies of objects as documents and sessions hold them: a closed surface, or voxels, eight in a byte."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
import scipy

from cpm_core.contours.surface import Surface, voxelize_surface
from cpm_core.image.volume_regions import Voxels
from cpm_core.numerics.grids import true_bounds, zero_surface
from cpm_core.numerics.types import Array, Index, Integers, Mask, Pixels, Place, frozen

Corner = Sequence[int] | Index
"""A voxel, or the sides of a box, (plane, row, col)."""

MAX_BOX_VOXELS = 2**28
"""Largest box around a surface [voxels]; filling it takes at least one byte per voxel."""


@frozen
class PackedSurface:
    """Closed surface in single precision.

    Attributes
    ----------
    vertices : bytes
        The vertices (plane, row, col) [voxels], float32, little-endian.
    faces : bytes
        The numbers of the three vertices of each triangle, from 0, int32, little-endian.

    Raises
    ------
    ValueError
        When the bytes hold no surface, or one that is not closed or far too large.
    """

    vertices: bytes
    faces: bytes

    def __post_init__(self) -> None:
        if not len(self.surface.faces) or not self.surface.closed:
            raise ValueError("The surface around an object is not closed, so nothing is inside.")
        sides = np.ceil(np.ptp(self.surface.vertices, axis=0)).tolist()
        if math.prod(sides) > MAX_BOX_VOXELS:
            raise ValueError(
                f"The surface around an object spans {' x '.join(f'{side:g}' for side in sides)} voxels, but at most "
                f"{MAX_BOX_VOXELS:,} in all can be filled: make it smaller."
            )

    @classmethod
    def from_surface(cls, surface: Surface) -> PackedSurface:
        """Pack a surface."""
        return cls(surface.vertices.astype("<f4").tobytes(), surface.faces.astype("<i4").tobytes())

    @cached_property
    def surface(self) -> Surface:
        """The surface [voxels]."""
        vertices, faces = np.dtype(("<f4", 3)), np.dtype(("<i4", 3))
        if len(self.vertices) % vertices.itemsize or len(self.faces) % faces.itemsize:
            raise ValueError("the surface of an object is damaged: it does not consist of triangles.")
        return Surface(np.frombuffer(self.vertices, vertices), np.frombuffer(self.faces, faces))

    @cached_property
    def voxels(self) -> Voxels:
        """The voxels whose centers lie inside."""
        vertices = self.surface.vertices
        first = np.floor(vertices.min(axis=0)).astype(int) - 1
        shape = np.ceil(vertices.max(axis=0)).astype(int) + 2 - first
        there = replace(self.surface, vertices=vertices - first)
        return Voxels(voxelize_surface(there, tuple(shape.tolist())), tuple(first.tolist()))

    @cached_property
    def as_packed_voxels(self) -> PackedVoxels:
        """Voxels of the same body, which a brush can change."""
        return PackedVoxels.from_voxels(self.voxels)

    def mask_in_box(self, begin: Corner, shape: Corner) -> Mask:
        """Return whether the voxels of a box, given its first voxel and its shape, have their centers inside."""
        return self.as_packed_voxels.mask_in_box(begin, shape)

    @property
    def volume(self) -> float:
        """Enclosed volume [voxels]."""
        return self.surface.volume

    @property
    def box(self) -> Array:
        """First and last plane, row and column of the vertices, shape (2, 3) [voxels]."""
        vertices = self.surface.vertices
        return np.array([vertices.min(axis=0), vertices.max(axis=0)])

    @property
    def shell(self) -> Voxels:
        """Voxels inside that share a face with one outside."""
        return _compute_shell(self.voxels)

    def translated(self, offset: Place) -> PackedSurface:
        """Return the surface displaced along each axis [voxels]."""
        return PackedSurface.from_surface(replace(self.surface, vertices=self.surface.vertices + np.array(offset)))


_BITS_PER_BYTE = 8
"""Number of voxels packed into a byte."""

_VOXEL_SMOOTHING = 0.8
"""Standard deviation that smooths the steps between voxels for a surface [voxels]."""

_SURFACE_MARGIN = 3
"""Empty voxels added on all sides before a surface is built [voxels]."""

_MIN_LEVEL_OFFSET = 0.15
"""Least difference of a smoothed voxel from the level of the surface, so that it stays on its side."""

_PLANES_PER_PIECE = 16
"""Planes of a surface that are built at once: meanwhile the interpreter does nothing else."""

_CACHED_BODIES = 32
"""Number of bodies whose surfaces and shells are cached: an undo stack holds many versions of each."""


@frozen
class PackedVoxels:
    """Voxels of a volume in a box, eight in a byte; edited copies share the planes that have not changed.

    Attributes
    ----------
    first : tuple of int
        The voxel that the box begins at, (plane, row, col).
    width : int
        Bytes of a row.
    planes : tuple of bytes
        Bytes of each plane, row after row.

    Raises
    ------
    ValueError
        When there is no voxel.
    """

    first: Integers
    width: int
    planes: tuple[bytes, ...]

    def __post_init__(self) -> None:
        if not _has_voxels(self.planes):
            raise ValueError("An object in a volume needs at least one voxel.")

    @classmethod
    def from_voxels(cls, voxels: Voxels) -> PackedVoxels:
        """Pack voxels into bits."""
        bits = np.packbits(voxels.mask, axis=2)
        return cls(voxels.first or (0, 0, 0), bits.shape[2], tuple(plane.tobytes() for plane in bits))

    @property
    def shape(self) -> tuple[int, int, int]:
        """Planes, rows and columns of the box."""
        return len(self.planes), len(self.planes[0]) // self.width, _BITS_PER_BYTE * self.width

    def mask_in_box(self, begin: Corner, shape: Corner) -> Mask:
        """Return whether the voxels of another box, given its first voxel and its shape, are set."""
        found = np.zeros(tuple(shape), bool)
        low, high = np.maximum(begin, self.first), np.minimum(np.add(begin, shape), np.add(self.first, self.shape))
        if (low < high).all():
            (plane, row, col), (planes, rows, cols) = low - self.first, high - low
            width = slice(col // _BITS_PER_BYTE, -(-(col + cols) // _BITS_PER_BYTE))
            raw = np.stack([self._plane_bytes(at)[row : row + rows, width] for at in range(plane, plane + planes)])
            bits = np.unpackbits(raw, axis=2).view(np.bool_)
            found[_box_slices(low, high, begin)] = bits[:, :, col % _BITS_PER_BYTE :][:, :, :cols]
        return found

    def with_box_replaced(self, begin: Corner, mask: Mask) -> PackedVoxels | None:
        """Replace the voxels of a box, given its first voxel and a mask of its shape; None when no voxel remains."""
        low, high = np.array(begin), np.add(begin, mask.shape)
        first, last = np.minimum(self.first, low), np.maximum(np.add(self.first, self.shape), high)
        first[2] -= (first[2] - self.first[2]) % _BITS_PER_BYTE
        last[2] += (first[2] - last[2]) % _BITS_PER_BYTE
        (_, rows, cols), planes = last - first, []
        same = (rows, cols) == self.shape[1:]
        for at in range(first[0], last[0]):
            changed = low[0] <= at < high[0]
            if same and not changed and 0 <= at - self.first[0] < len(self.planes):
                planes.append(self.planes[at - self.first[0]])
                continue
            bits = self.mask_in_box((at, first[1], first[2]), (1, rows, cols))[0]
            if changed:
                bits[_box_slices(low[1:], high[1:], first[1:])] = mask[at - low[0]]
            planes.append(np.packbits(bits, axis=1).tobytes())
        return (
            PackedVoxels(tuple(first.tolist()), cols // _BITS_PER_BYTE, tuple(planes)) if _has_voxels(planes) else None
        )

    @property
    def voxels(self) -> Voxels:
        """The voxels as a mask."""
        return Voxels(self.mask_in_box(self.first, self.shape), self.first)

    @property
    def shell(self) -> Voxels:
        """Voxels that share a face with one outside."""
        return _compute_shell(self.voxels)

    @property
    def surface(self) -> Surface:
        """Smooth surface around the voxels, which encloses exactly them [voxels]."""
        return _build_surface(self)

    @property
    def as_packed_voxels(self) -> PackedVoxels:
        """The body itself."""
        return self

    @property
    def volume(self) -> float:
        """Number of voxels."""
        return float(sum(int(np.bitwise_count(self._plane_bytes(at)).sum()) for at in range(len(self.planes))))

    @property
    def box(self) -> Array:
        """First and last plane, row and column of the voxels, shape (2, 3)."""
        return true_bounds(self.mask_in_box(self.first, self.shape)).astype(float) + self.first

    def translated(self, offset: Place) -> PackedVoxels:
        """Return the voxels displaced along each axis, to the nearest whole voxel."""
        return replace(self, first=tuple(np.rint(np.add(self.first, offset)).astype(int).tolist()))

    def _plane_bytes(self, plane: int) -> Pixels:
        """Return the bytes of a plane of the box, shape (rows, width)."""
        return np.frombuffer(self.planes[plane], np.uint8).reshape(-1, self.width)


PackedBody = PackedVoxels | PackedSurface


def _has_voxels(planes: Sequence[bytes]) -> bool:
    return any(plane != bytes(len(plane)) for plane in planes)


def _box_slices(low: Index, high: Index, begin: Corner) -> tuple[slice, ...]:
    """Return the slices of a box in an array that begins at a voxel."""
    return tuple(map(slice, low - begin, high - begin))


@lru_cache(maxsize=_CACHED_BODIES)
def _compute_shell(voxels: Voxels) -> Voxels:
    return Voxels(voxels.mask & ~scipy.ndimage.binary_erosion(voxels.mask), voxels.first)


@lru_cache(maxsize=_CACHED_BODIES)
def _build_surface(body: PackedVoxels) -> Surface:
    inside = np.pad(body.voxels.mask, _SURFACE_MARGIN)
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
    return Surface(ordered[is_new] + np.array(body.first) - _SURFACE_MARGIN, numbers[faces])
