"""Types of the whole program; shapes and units are given where the types are used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, TypeVar, dataclass_transform

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Positions, forces, images: values in double precision."""

NO_POINTS: Array = np.empty((0, 2))
"""No positions in an image."""

Single = NDArray[np.float32]
"""Values in single precision, where that is enough and faster."""

Index = NDArray[np.int64]
"""Indices and counts."""

NO_PIXELS: Index = np.empty((0, 2), np.int64)
"""No pixels of an image."""

Mask = NDArray[np.bool_]
"""Truth values: a mask of pixels, or of the selected items."""

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
"""Integers: counts or indices."""

Arrays = tuple[Array, ...]
"""Several arrays, such as the points of several lines."""

Sides = tuple[float, ...]
"""Side of a pixel or voxel along each axis."""

JsonObject = Mapping[str, Any]
"""JSON object, as read from a file."""

JsonDict = dict[str, Any]
"""JSON object under construction."""

Callback = Callable[[], object]
"""Function without arguments."""

_Kind = TypeVar("_Kind")
_Given = TypeVar("_Given")


def _get_fields(given: Any) -> JsonDict:
    """Return the fields of a dataclass by name: what is pickled, as all else is computed from them when asked for."""
    return {name: vars(given)[name] for name in given.__dataclass_fields__ if name in vars(given)}


def copy_with(given: _Given, **changed: Any) -> _Given:
    """Copy an object with other attributes, and with all that it has computed and kept."""
    other = object.__new__(type(given))
    vars(other).update(vars(given), **changed)
    return other


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def frozen(kind: type[_Kind]) -> type[_Kind]:
    """Make a frozen dataclass whose instances are equal if their fields are."""
    kind.__getstate__ = _get_fields  # type: ignore[assignment]
    return dataclass(frozen=True)(kind)


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
def record(kind: type[_Kind]) -> type[_Kind]:
    """Make a frozen dataclass whose instances are equal only to themselves, since arrays are not compared."""
    kind.__getstate__ = _get_fields  # type: ignore[assignment]
    return dataclass(frozen=True, eq=False)(kind)
