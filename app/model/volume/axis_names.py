"""How a volume lies: the names of the ends of its axes, and which way up it is shown.

Where an image tells how a patient lies, slices and the view in space are shown as they are read: what is anterior or
superior is above, the right of the patient is at the left, and from the side the patient looks to the left.
"""

from __future__ import annotations

import numpy as np

from app.model.text.language import tr
from app.model.volume.slices import AXES, Slices
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array

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
    if volume is None or axis is None or volume.geometry is None:
        return False, False
    (_, below), (_, right) = (ends for index, ends in enumerate(volume.geometry.ends) if index != axis)
    return below in _ABOVE, right in _LEFT


def edges_of(whole: Image, slices: Slices | None) -> tuple[Ends, Ends] | None:
    """What is written at the top and bottom, and at the left and right, of an image or of a slice of a volume.

    None for an image that does not tell how it lies.
    """
    if slices is None and whole.geometry is None:
        return None
    axis = 0 if slices is None else slices.axis
    down, right = (ends for index, ends in enumerate(ends_of(whole)) if index != axis)
    upside_down, leftward = flips_of(whole, None if slices is None else axis)
    return down[::-1] if upside_down else down, right[::-1] if leftward else right


def planes_of(volume: Image) -> tuple[str, str, str]:
    """What slices across the axes are called: axial, coronal and sagittal ones of a patient."""
    if volume.geometry is None:
        return AXES
    across_plane, across_row, across_column = (_PLANES[end] for _, end in volume.geometry.ends)
    return across_plane, across_row, across_column


def directions_of(volume: Image) -> tuple[Array, ...]:
    """Directions to the right, down and away, one a row, along (plane, row, col), as slices across each axis lie."""
    handed = _MIRRORED if volume.geometry is None else _handed([end for _, end in volume.geometry.ends])
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
    if volume.geometry is None:
        return 0
    return next(axis for axis, (_, end) in enumerate(volume.geometry.ends) if end in "AP")


def _handed(letters: list[str]) -> float:
    """1 where axes that end at these letters are right-handed, else -1."""
    along = np.array([[(letter == pair[0]) - float(letter == pair[1]) for pair in _PATIENT] for letter in letters])
    return float(np.linalg.det(along))
