"""What a file of a surface holds, as a reader finds it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.numerics.types import Array, Index


class Triangles(NamedTuple):
    """Triangles in the coordinates of a file.

    Attributes
    ----------
    points : ndarray of float64, shape (N, 3)
        Positions (x, y, z).
    faces : ndarray of int64, shape (F, 3)
        Corners of each triangle.
    remarks : str
        Comments and titles of the file, which may tell its coordinates and its unit.
    numbers : ndarray of int64, shape (F,), or None
        Number of the object that each triangle bounds.
    """

    points: Array
    faces: Index
    remarks: str = ""
    numbers: Index | None = None


def split(counts: ArrayLike, corners: ArrayLike) -> tuple[Index, Index]:
    """Polygons as triangles around their first corner, and which polygon each triangle is a part of.

    `counts` are the numbers of corners of the polygons, and `corners` the corners of all of them, one after the other.
    """
    sizes, ends = np.asarray(counts, np.int64), np.asarray(corners, np.int64)
    if len(sizes) and sizes.min() < 0:
        raise UnreadableError("a polygon has a negative number of corners")
    if int(sizes.sum()) != len(ends):
        raise UnreadableError("polygons do not have as many corners as they say")
    parts = np.maximum(sizes - 2, 0)
    of = np.repeat(np.arange(len(sizes)), parts)
    first = (np.cumsum(sizes) - sizes)[of]
    place = np.arange(len(of)) - (np.cumsum(parts) - parts)[of]
    return np.stack([ends[first], ends[first + place + 1], ends[first + place + 2]], axis=1), of


def table_of(text: bytes | str, columns: int, count: int) -> NDArray[Any]:
    """So many rows of numbers of a text."""
    words = text.split()
    if len(words) < columns * count:
        raise UnreadableError("it ends before its last number")
    return np.array(words[: columns * count], dtype=np.float64).reshape(count, columns)
