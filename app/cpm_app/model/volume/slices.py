"""The slices of a volume, one across each axis, the names of its axes, and its field in them."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_app.model.text.language import tr
from cpm_core import Image
from cpm_core.numerics import Array, Place, Position, Single
from cpm_core.numerics.types import Arrays, Extent, Integers, Sides, frozen, record
from cpm_core.shapes import sides_of

T = TypeVar("T")
V = TypeVar("V", bound=np.generic)

AXES = (tr("plane"), tr("row"), tr("column"))
"""Names of the axes of a volume: a slice lies across one of them."""


@frozen
class Slice:
    """A slice across an axis of a volume, 0 for planes, 1 for rows and 2 for columns, at an index along it.

    A position in it is (row, col) of the canvas: the two other axes of the volume, in their order.
    """

    axis: int
    index: int

    def lifted(self, position: Position) -> Place:
        """The position in the volume of one in the slice."""
        return (*position[: self.axis], float(self.index), *position[self.axis :])

    def along(self, by: Position) -> Place:
        """A displacement in the slice as one in the volume."""
        return replace(self, index=0).lifted(by)

    def within(self, place: tuple[T, ...]) -> tuple[T, ...]:
        """The position in the slice nearest to one in the volume; of three numbers those of the axes of the slice."""
        return place[: self.axis] + place[self.axis + 1 :]

    def flattened(self, places: Array) -> Array:
        """Positions in the slice, shape (N, 2), nearest to those in the volume, shape (N, 3)."""
        return places[:, [axis for axis in range(3) if axis != self.axis]]

    def of(self, values: NDArray[V]) -> NDArray[V]:
        """The slice of an array, without a copy."""
        found: NDArray[V] = values[(slice(None),) * self.axis + (self.index,)]
        return found


@frozen
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

    shape: Extent
    voxel: Integers
    axis: int = 0

    @classmethod
    def of(cls, shape: Extent) -> Slices | None:
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


Ends = tuple[str, str]
"""What is written where an axis begins, and where it ends."""

_PLANES = {"I": tr("axial"), "S": tr("axial"), "A": tr("coronal"), "P": tr("coronal"),
           "L": tr("sagittal"), "R": tr("sagittal")}  # fmt: skip
"""What slices across an axis that ends at a letter are called."""

_ABOVE, _LEFT = "AS", "RA"
"""Ends that lie above, and at the left."""

_PATIENT = ("LR", "PA", "SI")
"""Letters along three axes at right angles, which are right-handed: to the first ones, and away from them."""

_MIRRORED = -1.0
"""Handedness of plane, row and column where nothing is known: planes lead away, rows down, columns to the right."""


def ends_of(image: Image) -> tuple[Ends, Ends, Ends]:
    """The ends of the axes (plane, row, column) of a volume, or of the volume that an image is a plane of."""
    if image.geometry is not None:
        return image.geometry.ends
    plane, row, column = (("", name) for name in AXES)
    return plane, row, column


def flips_of(volume: Image | None, axis: int | None) -> tuple[bool, bool]:
    """Whether a slice across an axis is shown upside down, and from right to left."""
    if volume is None or axis is None:
        return False, False
    (_, below), (_, right) = (ends for index, ends in enumerate(ends_of(volume)) if index != axis)
    return below in _ABOVE, right in _LEFT


def edges_of(whole: Image, slices: Slices | None) -> tuple[Ends, Ends] | None:
    """What is written at the top and bottom, and at the left and right, of an image or of a slice of a volume.

    None for an image without a place in space.
    """
    if slices is None and whole.geometry is None:
        return None
    axis = 0 if slices is None else slices.axis
    down, right = (ends for index, ends in enumerate(ends_of(whole)) if index != axis)
    upside_down, leftward = flips_of(whole, None if slices is None else axis)
    return down[::-1] if upside_down else down, right[::-1] if leftward else right


def planes_of(volume: Image) -> tuple[str, str, str]:
    """What slices across the axes are called: axial, coronal and sagittal ones of a patient."""
    plane, row, column = (_PLANES.get(end, end) for _, end in ends_of(volume))
    return plane, row, column


def directions_of(volume: Image) -> Arrays:
    """Directions to the right, down and away, one a row, along (plane, row, col), as slices across each axis lie."""
    along = [[(end == pair[0]) - (end == pair[1]) for pair in _PATIENT] for _, end in ends_of(volume)]
    handed = float(np.linalg.det(np.array(along, float))) or _MIRRORED
    found = []
    for axis in range(3):
        down, right = (other for other in range(3) if other != axis)
        upside_down, leftward = flips_of(volume, axis)
        seen = np.zeros((3, 3))
        seen[0, right], seen[1, down], seen[2, axis] = -1.0 if leftward else 1.0, -1.0 if upside_down else 1.0, 1.0
        seen[2] *= handed * np.linalg.det(seen)
        found.append(seen)
    return tuple(found)


def first_seen(volume: Image) -> int:
    """The axis along which a volume is seen first in space: a patient from the front."""
    return next((axis for axis, (_, end) in enumerate(ends_of(volume)) if end in "AP"), 0)


_MOST_FORCES = 1 << 18
"""Voxels of which a force is kept, at most about so many: a view shows some hundred arrows."""


@record
class SampledForce:
    """The force on every so manieth voxel, shape (3, P, R, C), in smallest sides of a voxel, and those sides."""

    force: Single
    step: int
    sides: Sides

    @classmethod
    def of(cls, force: Array, spacing: Sides) -> SampledForce:
        """That of a force on all voxels, of which nothing is kept."""
        step = max(1, int(np.ceil((force[0].size / _MOST_FORCES) ** (1.0 / 3.0))))
        return cls(force[:, ::step, ::step, ::step].astype(np.float32), step, sides_of(spacing))

    def slice_of(self, here: Slice, shape: Extent) -> Array:
        """The force along a slice of this shape, (2, H, W), as a displacement in its pixels."""
        places = np.insert(np.indices(shape) / self.step, here.axis, here.index / self.step, axis=0)
        along = [
            scipy.ndimage.map_coordinates(force, places, float, order=1, mode="nearest") / side
            for force, side in zip(here.within(tuple(self.force)), here.within(self.sides), strict=True)
        ]
        return np.stack(along)
