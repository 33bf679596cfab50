"""Content of a surface file as a reader finds it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.formats.common.content import UnreadableError
from cpm_core.numerics.polyline import repeat_indices
from cpm_core.numerics.types import Array, Index

NUMBER_KINDS = {
    **{"char": "i1", "short": "i2", "int": "i4", "long": "i8", "vtktypeint64": "i8", "vtkidtype": "i8"},
    **{"uchar": "u1", "ushort": "u2", "uint": "u4", "float": "f4", "double": "f8"},
    **{"unsigned_char": "u1", "unsigned_short": "u2", "unsigned_int": "u4", "unsigned_long": "u8"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float32": "f4", "float64": "f8"},
}
"""Names of number types in PLY and VTK -> types of NumPy."""


class ParsedTriangles(NamedTuple):
    """Triangles in the coordinates of a file.

    Attributes
    ----------
    points : ndarray of float64, shape (N, 3)
        Positions (x, y, z).
    faces : ndarray of int64, shape (F, 3)
        Corners of each triangle.
    numbers : ndarray of int64, shape (F,), or None
        Number of the object that each triangle bounds.
    """

    points: Array
    faces: Index
    numbers: Index | None = None


def triangulate_polygons(counts: ArrayLike, corners: ArrayLike) -> tuple[Index, Index]:
    """Split polygons into triangles around their first corner.

    Parameters
    ----------
    counts : array_like of int, shape (M,)
        Number of corners of each polygon.
    corners : array_like of int, shape (sum of `counts`,)
        Corners of all polygons, one after the other.

    Returns
    -------
    faces : ndarray of int64, shape (F, 3)
        Corners of each triangle.
    polygon : ndarray of int64, shape (F,)
        Polygon that each triangle is part of.

    Raises
    ------
    UnreadableError
        When there are no polygons, or they have another number of corners.
    """
    sizes, ends = np.asarray(counts, np.int64), np.asarray(corners, np.int64)
    if not len(sizes):
        raise UnreadableError("It has no triangles: write it again.")
    if sizes.min() < 0 or sizes.astype(float).sum() != len(ends):
        raise UnreadableError("Its polygons have another number of corners than it says: write it again.")
    parts = np.maximum(sizes - 2, 0)
    polygon = repeat_indices(parts)
    first = (np.cumsum(sizes) - sizes)[polygon]
    place = np.arange(len(polygon)) - (np.cumsum(parts) - parts)[polygon]
    return np.stack([ends[first], ends[first + place + 1], ends[first + place + 2]], axis=1), polygon
