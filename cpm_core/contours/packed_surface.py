"""Arrays and surfaces as text, as sessions hold them: compressed bytes, which are checked before they are unpacked."""

from __future__ import annotations

import base64
import binascii
import math
import zlib
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import DTypeLike, NDArray

from cpm_core.contours.surface import Surface, inside_of
from cpm_core.image.volume_regions import Voxels
from cpm_core.numerics.types import Place

_LARGEST = 256 * 2**20
"""Most bytes of an array that is read."""

MOST_VOXELS = 2**28
"""Most voxels of the box around a surface, whose inside takes a byte for each and more while it is found."""

_FAST = 1
"""Level of compression: bits of positions hardly become fewer, however long one tries."""


def packed(array: NDArray[Any]) -> str:
    """The bytes of an array of numbers, low ones first, as text."""
    data = np.ascontiguousarray(array).astype(array.dtype.newbyteorder("<"), copy=False).tobytes()
    return base64.b64encode(zlib.compress(data, _FAST)).decode()


def unpacked(text: object, dtype: DTypeLike, count: int | None, where: str) -> NDArray[Any]:
    """So many numbers of this type, None for any number of them; else ValueError, which names `where`."""
    kind = np.dtype(dtype).newbyteorder("<")
    size = _LARGEST if count is None else count * kind.itemsize
    if not isinstance(text, str) or size > _LARGEST:
        raise ValueError(f"{where} holds no array that can be read.")
    try:
        unpacking = zlib.decompressobj()
        data = unpacking.decompress(base64.b64decode(text, validate=True), size + 1)
    except (zlib.error, binascii.Error, ValueError) as error:
        raise ValueError(f"{where} is damaged.") from error
    if (len(data) != size if count is not None else len(data) > size or len(data) % kind.itemsize) or not unpacking.eof:
        raise ValueError(f"{where} is damaged: it does not hold what its shape says.")
    return np.frombuffer(data, kind).astype(dtype)


@dataclass(frozen=True)
class PackedSurface:
    """A closed surface as text, to single precision.

    Attributes
    ----------
    vertices, faces : str
        Its vertices [voxels] and triangles.

    Raises
    ------
    ValueError
        When the text holds no surface, or one that is not closed or far too large.
    """

    vertices: str
    faces: str

    def __post_init__(self) -> None:
        if not len(self.surface.faces) or not self.surface.closed:
            raise ValueError("The surface around an object is not closed, so nothing is inside.")
        sides = np.ceil(np.ptp(self.surface.vertices, axis=0)).tolist()
        if math.prod(sides) > MOST_VOXELS:
            raise ValueError(
                f"The surface around an object spans {' x '.join(f'{side:g}' for side in sides)} voxels, but at most "
                f"{MOST_VOXELS:,} in all can be filled: make it smaller."
            )

    @classmethod
    def of(cls, surface: Surface) -> PackedSurface:
        """The surface as text."""
        return cls(packed(surface.vertices.astype(np.float32)), packed(surface.faces.astype(np.int32)))

    @cached_property
    def surface(self) -> Surface:
        """The surface, in voxels."""
        vertices = unpacked(self.vertices, np.float32, None, "the surface of an object")
        faces = unpacked(self.faces, np.int32, None, "the surface of an object")
        if len(vertices) % 3 or len(faces) % 3:
            raise ValueError("the surface of an object is damaged: it does not consist of triangles.")
        return Surface(vertices.reshape(-1, 3), faces.reshape(-1, 3))

    @cached_property
    def voxels(self) -> Voxels:
        """The voxels whose centers lie inside."""
        vertices = self.surface.vertices
        first = np.floor(vertices.min(axis=0)).astype(int) - 1
        shape = np.ceil(vertices.max(axis=0)).astype(int) + 2 - first
        there = replace(self.surface, vertices=vertices - first)
        return Voxels(inside_of(there, tuple(shape.tolist())), tuple(first.tolist()))

    @cached_property
    def shell(self) -> Voxels:
        """Those of them that have a side in common with a voxel outside."""
        inside = self.voxels.mask
        return Voxels(inside & ~scipy.ndimage.binary_erosion(inside), self.voxels.first)

    def moved(self, by: Place) -> PackedSurface:
        """The same surface displaced by so much along each axis [voxels]."""
        return PackedSurface.of(replace(self.surface, vertices=self.surface.vertices + np.array(by)))
