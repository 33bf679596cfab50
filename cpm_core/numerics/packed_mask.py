"""Masks that take an eighth of their size, and share with changed copies all planes that are the same."""

from __future__ import annotations

import math

import numpy as np

from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Extent, Mask, frozen


@frozen
class PackedMask:
    """A mask of pixels or voxels, eight in a byte.

    Attributes
    ----------
    shape : tuple of int
        Its shape: (rows, columns) or (planes, rows, columns).
    planes : tuple of bytes
        The bits of each plane, row by row; those of an image are one plane.
    """

    shape: Extent
    planes: tuple[bytes, ...]

    @classmethod
    def pack(cls, mask: Mask) -> PackedMask:
        """Pack a mask, shape (H, W) or (P, H, W)."""
        planes = mask if mask.ndim == 3 else mask[None]
        return cls(mask.shape, tuple(np.packbits(plane).tobytes() for plane in planes))

    def unpack(self) -> Mask:
        """Return the whole mask."""
        return self.cut(tuple(slice(0, side) for side in self.shape))

    def cut(self, window: Window) -> Mask:
        """Return the part in a window; only its rows are unpacked."""
        *deep, rows, cols = window
        planes = self.planes[deep[0]] if deep else self.planes
        width, shape = self.shape[-1], (rows.stop - rows.start, self.shape[-1])
        first, end = rows.start * width, rows.stop * width
        found = np.empty((len(planes), *shape), bool)
        for plane, bits in zip(found, planes, strict=True):
            some = np.unpackbits(np.frombuffer(bits, np.uint8)[first // 8 : -(-end // 8)])[first % 8 :]
            plane[:] = some[: math.prod(shape)].reshape(shape)
        found = found[..., cols]
        return found if deep else found[0]

    def changed(self, window: Window, part: Mask, adds: bool) -> PackedMask:
        """Return the mask with the pixels of a part in a window added, or removed."""
        deep, flat = (window[0], window[1:]) if len(window) == 3 else (slice(0, 1), window)
        planes = list(self.planes)
        for at, piece in zip(range(deep.start, deep.stop), part if len(window) == 3 else part[None], strict=True):
            if piece.any():
                plane = np.unpackbits(np.frombuffer(planes[at], np.uint8)).view(bool)
                there = plane[: math.prod(self.shape[-2:])].reshape(self.shape[-2:])[flat]
                there[:] = there | piece if adds else there & ~piece
                planes[at] = np.packbits(plane).tobytes()
        return PackedMask(self.shape, tuple(planes))

    @property
    def count(self) -> int:
        """Number of true pixels."""
        return int(np.bitwise_count(np.frombuffer(b"".join(self.planes), np.uint8)).sum(dtype=np.int64))

    @property
    def is_tight(self) -> bool:
        """Whether true pixels touch every side of the box."""
        ends = [(axis, at) for axis, side in enumerate(self.shape) for at in (0, side - 1)]
        whole = [slice(0, side) for side in self.shape]
        return all(self.cut((*whole[:axis], slice(at, at + 1), *whole[axis + 1 :])).any() for axis, at in ends)
