"""The slices of a volume that are shown: one frozen value, the place in the volume and the axis that is worked on."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from app.model.text.language import tr
from cpm_core.numerics.types import Array, Place, Position

T = TypeVar("T", int, float)
V = TypeVar("V", bound=np.generic)

AXES = (tr("plane"), tr("row"), tr("column"))
"""Names of the axes of a volume: a slice lies across one of them."""


@dataclass(frozen=True, slots=True)
class Slice:
    """A slice across an axis of a volume, 0 for planes, 1 for rows and 2 for columns, at an index along it.

    A position in it is (row, col) of the canvas: the two other axes of the volume, in their order.
    """

    axis: int
    index: int

    def lifted(self, position: Position) -> Place:
        """The position in the volume of one in the slice."""
        first, second = position
        place = [first, second]
        place.insert(self.axis, float(self.index))
        return tuple(place)

    def along(self, by: Position) -> Place:
        """A displacement in the slice as one in the volume."""
        return replace(self, index=0).lifted(by)

    def within(self, place: Place) -> Position:
        """The position in the slice that is nearest to one in the volume."""
        return place[: self.axis] + place[self.axis + 1 :]

    def flattened(self, places: Array) -> Array:
        """Positions in the slice, shape (N, 2), nearest to those in the volume, shape (N, 3)."""
        return places[:, [axis for axis in range(3) if axis != self.axis]]

    def of(self, values: NDArray[V]) -> NDArray[V]:
        """The slice of an array, without a copy."""
        found: NDArray[V] = values[(slice(None),) * self.axis + (self.index,)]
        return found

    def sides(self, lengths: tuple[T, ...]) -> tuple[T, ...]:
        """Those of three numbers that belong to the axes of the slice."""
        return lengths[: self.axis] + lengths[self.axis + 1 :]


@dataclass(frozen=True, slots=True)
class Slices:
    """The three slices through one voxel of a volume.

    Attributes
    ----------
    shape : tuple of int
        Planes, rows and columns of the volume.
    voxel : tuple of int
        Where the slices meet.
    axis : int
        The axis of the slice that is worked on.
    """

    shape: tuple[int, ...]
    voxel: tuple[int, ...]
    axis: int = 0

    @classmethod
    def of(cls, shape: tuple[int, ...]) -> Slices | None:
        """The slices through the middle of a volume; None for the shape of an image."""
        return cls(shape, tuple(side // 2 for side in shape)) if len(shape) == 3 else None

    @property
    def current(self) -> Slice:
        """The slice that is worked on."""
        return self.across(self.axis)

    @property
    def count(self) -> int:
        """Number of slices across the current axis."""
        return self.shape[self.axis]

    def across(self, axis: int) -> Slice:
        """The slice across an axis."""
        return Slice(axis, self.voxel[axis])

    def turned(self, axis: int) -> Slices:
        """The same place with another axis to work on."""
        return replace(self, axis=axis)

    def at(self, index: int) -> Slices:
        """The slices with the current one at another index, within the volume."""
        voxel = [*self.voxel]
        voxel[self.axis] = index
        return self.through(tuple(voxel))

    def through(self, place: Place) -> Slices:
        """The slices through another voxel, the nearest one in the volume."""
        nearest = (min(max(round(at), 0), side - 1) for at, side in zip(place, self.shape, strict=True))
        return replace(self, voxel=tuple(nearest))
