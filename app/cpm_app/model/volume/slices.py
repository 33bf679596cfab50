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
from cpm_core.shapes import relative_sides

ElementT = TypeVar("ElementT")
ScalarT = TypeVar("ScalarT", bound=np.generic)

AXIS_NAMES = (tr("plane"), tr("row"), tr("column"))
"""Names of the axes of a volume: a slice lies across one of them."""


@frozen
class Slice:
    """A slice across an axis of a volume, 0 for planes, 1 for rows and 2 for columns, at an index along it.

    A position in it is (row, col) of the canvas: the other two axes of the volume, in their order, or exchanged in a
    slice that is `transposed`.
    """

    axis: int
    index: int
    transposed: bool = False

    @property
    def axes(self) -> tuple[int, int]:
        """Axes of the volume along (row, col) of the slice."""
        first, second = (other for other in range(3) if other != self.axis)
        return (second, first) if self.transposed else (first, second)

    def lift_position(self, position: Position) -> Place:
        """Convert a position in the slice to one in the volume."""
        at = dict(zip(self.axes, position, strict=True))
        return tuple(at.get(axis, float(self.index)) for axis in range(3))

    def lift_offset(self, offset: Position) -> Place:
        """Convert a displacement in the slice to one in the volume."""
        return replace(self, index=0).lift_position(offset)

    def drop_axis(self, values: tuple[ElementT, ...]) -> tuple[ElementT, ...]:
        """Drop the value along the axis of the slice: a position in the volume becomes the nearest in the slice."""
        return tuple(values[axis] for axis in self.axes)

    def project_points(self, places: Array) -> Array:
        """Project positions in the volume, shape (N, 3), onto the slice, shape (N, 2)."""
        return places[:, self.axes]

    def slice_array(self, values: NDArray[ScalarT]) -> NDArray[ScalarT]:
        """Take the slice, shape (H, W), of an array of shape (P, R, C), without a copy."""
        found: NDArray[ScalarT] = values[(slice(None),) * self.axis + (self.index,)]
        return found.T if self.transposed else found


@frozen
class Slices:
    """The three slices through one voxel of a volume.

    Attributes
    ----------
    shape : tuple of int
        Planes, rows and columns of the volume.
    voxel : tuple of int
        Voxel where the slices meet.
    axis : int
        The axis of the slice that is worked on.
    transposed : tuple of bool
        Whether the slice across each axis is transposed.
    """

    shape: Extent
    voxel: Integers
    axis: int = 0
    transposed: tuple[bool, ...] = (False, False, False)

    @classmethod
    def through_middle(cls, image: Image) -> Slices | None:
        """Return the slices through the middle of a volume; None for an image with two axes."""
        if image.ndim != 3:
            return None
        middle = tuple(side // 2 for side in image.shape)
        return cls(image.shape, middle, 0, tuple(is_transposed(image, axis) for axis in range(3)))

    @property
    def current(self) -> Slice:
        """The slice that is worked on."""
        return self.slice_across(self.axis)

    @property
    def count(self) -> int:
        """Number of slices across the current axis."""
        return self.shape[self.axis]

    def slice_across(self, axis: int) -> Slice:
        """Return the slice across an axis."""
        return Slice(axis, self.voxel[axis], self.transposed[axis])

    def with_axis(self, axis: int) -> Slices:
        """Work on another axis, at the same voxel."""
        return replace(self, axis=axis)

    def with_index(self, index: int) -> Slices:
        """Move the current slice to another index, within the volume."""
        voxel = [*self.voxel]
        voxel[self.axis] = index
        return self.with_voxel(tuple(voxel))

    def with_voxel(self, place: Place) -> Slices:
        """Move the slices to another voxel, the nearest one in the volume."""
        nearest = (min(max(round(at), 0), side - 1) for at, side in zip(place, self.shape, strict=True))
        return replace(self, voxel=tuple(nearest))


AxisEnds = tuple[str, str]
"""Labels of an axis where it begins and where it ends."""

_PLANE_NAMES = {"I": tr("axial"), "S": tr("axial"), "A": tr("coronal"), "P": tr("coronal"),
           "L": tr("sagittal"), "R": tr("sagittal")}  # fmt: skip
"""Names of slices across an axis, by the letter at its end."""

_TOP_ENDS = "AS"
"""Ends of axes that are shown at the top."""

_LEFT_ENDS = "RA"
"""Ends of axes that are shown at the left."""

_UPRIGHT_ENDS = ("SI", "AP", "LR")
"""Ends of axes by their right to run down: superior or else anterior is up."""

_PATIENT_AXES = ("LR", "PA", "SI")
"""Ends of three right-handed orthogonal axes of a patient: toward the first letter, and away from it."""

_DEFAULT_HANDEDNESS = -1.0
"""Handedness of unknown axes: planes lead away, rows down, columns to the right."""


def axis_ends(image: Image) -> tuple[AxisEnds, AxisEnds, AxisEnds]:
    """Return the ends of the axes (plane, row, column) of a volume, or of the volume that an image is a plane of."""
    if image.geometry is not None:
        return image.geometry.ends
    plane, row, column = (("", name) for name in AXIS_NAMES)
    return plane, row, column


def is_transposed(volume: Image, axis: int) -> bool:
    """Tell whether the slice across an axis is shown with its rows as columns, so that what is superior is up."""
    if volume.geometry is None:
        return False
    ends = axis_ends(volume)
    down, right = (
        next(rank for rank, pair in enumerate(_UPRIGHT_ENDS) if ends[along][1] in pair) for along in Slice(axis, 0).axes
    )
    return right < down


def find_slice_flips(volume: Image | None, here: Slice | None) -> tuple[bool, bool]:
    """Tell whether a slice is shown upside down, and whether from right to left."""
    if volume is None or here is None:
        return False, False
    (_, below), (_, right) = here.drop_axis(axis_ends(volume))
    return below in _TOP_ENDS, right in _LEFT_ENDS


def axis_labels(image: Image) -> tuple[AxisEnds, ...]:
    """Return what is written at the ends of the axes: as `axis_ends`, in an oblique volume several letters."""
    return axis_ends(image) if image.geometry is None else image.geometry.oblique_ends


def find_edge_labels(whole: Image, slices: Slices | None) -> tuple[AxisEnds, AxisEnds] | None:
    """Return what is written at top and bottom, and at left and right, of an image or of a slice of a volume.

    None for an image without a place in space.
    """
    if slices is None and whole.geometry is None:
        return None
    here = None if slices is None else slices.current
    down, right = (here or Slice(0, 0)).drop_axis(axis_labels(whole))
    upside_down, leftward = find_slice_flips(whole, here)
    return down[::-1] if upside_down else down, right[::-1] if leftward else right


def name_slices(volume: Image) -> tuple[str, str, str]:
    """Name the slices across the axes: axial, coronal and sagittal for a patient."""
    plane, row, column = (_PLANE_NAMES.get(end, end) for _, end in axis_ends(volume))
    return plane, row, column


def slice_directions(volume: Image) -> Arrays:
    """Return the directions to the right, down and away in the slice across each axis.

    There is an array of shape (3, 3) for each axis, with a direction a row, along (plane, row, col).
    """
    along = [[(end == pair[0]) - (end == pair[1]) for pair in _PATIENT_AXES] for _, end in axis_ends(volume)]
    handed = float(np.linalg.det(np.array(along, float))) or _DEFAULT_HANDEDNESS
    found = []
    for axis in range(3):
        here = Slice(axis, 0, is_transposed(volume, axis))
        (down, right), (upside_down, leftward) = here.axes, find_slice_flips(volume, here)
        seen = np.zeros((3, 3))
        seen[0, right], seen[1, down], seen[2, axis] = -1.0 if leftward else 1.0, -1.0 if upside_down else 1.0, 1.0
        seen[2] *= handed * np.linalg.det(seen)
        found.append(seen)
    return tuple(found)


def find_front_axis(volume: Image) -> int:
    """Return the axis along which a volume is seen first in space: a patient from the front."""
    return next((axis for axis, (_, end) in enumerate(axis_ends(volume)) if end in "AP"), 0)


_MAX_FORCE_VOXELS = 1 << 18
"""Approximate largest number of voxels whose force is stored: a view shows some hundred arrows."""


@record
class SampledForce:
    """Force on every n-th voxel, shape (3, P, R, C), in smallest sides of a voxel, and the sides of a voxel."""

    force: Single
    stride: int
    sides: Sides

    @classmethod
    def from_force(cls, force: Array, spacing: Sides) -> SampledForce:
        """Sample a force on all voxels, shape (3, P, R, C), in a copy that does not refer to it."""
        step = max(1, int(np.ceil((force[0].size / _MAX_FORCE_VOXELS) ** (1.0 / 3.0))))
        return cls(force[:, ::step, ::step, ::step].astype(np.float32), step, relative_sides(spacing))

    def interpolate_slice(self, here: Slice, shape: Extent) -> Array:
        """Interpolate the force along a slice of this shape, (2, H, W), as a displacement in its pixels."""
        places = np.full((3, *shape), here.index / self.stride)
        places[list(here.axes)] = np.indices(shape) / self.stride
        along = [
            scipy.ndimage.map_coordinates(force, places, float, order=1, mode="nearest") / side
            for force, side in zip(here.drop_axis(tuple(self.force)), here.drop_axis(self.sides), strict=True)
        ]
        return np.stack(along)
