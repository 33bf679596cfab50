"""Types of the whole program; shapes and units are given where the types are used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, TypeVar, dataclass_transform

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Positions, forces, images: values in double precision."""

Single = NDArray[np.float32]
"""Values in single precision, where that is enough and faster."""

Index = NDArray[np.int64]
"""Indices and counts."""

Mask = NDArray[np.bool_]
"""Which of some things are chosen, or which pixels."""

Pixels = NDArray[np.uint8]
"""Pixels for the screen, (H, W) or (H, W, 3)."""

Texts = tuple[str, ...]
"""Names or sentences, one after the other."""

Numbers = NDArray[Any]
"""Numbers of any type."""

Position = Annotated[tuple[float, ...], 2]
"""A position (row, col) [px]; the annotation is how many numbers it has in files."""

Place = Annotated[tuple[float, ...], 2, 3]
"""A position (row, col) in an image or (plane, row, col) in a volume [px, voxels]."""

Voxel = Annotated[tuple[float, ...], 3]
"""A position (plane, row, col) [voxels]."""

Line = tuple[Position, ...]
"""Corners of a line."""

Extent = tuple[int, ...]
"""How many pixels or voxels there are along each axis."""

Integers = tuple[int, ...]
"""Whole numbers: counts, or which of some things."""

Arrays = tuple[Array, ...]
"""Arrays, as the points of several lines."""

Sides = tuple[float, ...]
"""Side of a pixel or voxel along each axis."""

Plain = Mapping[str, Any]
"""What files hold by name, as JSON."""

Entries = dict[str, Any]
"""The same, while it is put together."""

Callback = Callable[[], object]
"""What is called without anything."""

_Kind = TypeVar("_Kind")


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(kind: type[_Kind]) -> type[_Kind]:
    """A frozen dataclass of which two are equal if their fields are."""
    return dataclass(frozen=True)(kind)


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
def record(kind: type[_Kind]) -> type[_Kind]:
    """A frozen dataclass of which each is equal to itself alone, since arrays are not compared."""
    return dataclass(frozen=True, eq=False)(kind)
