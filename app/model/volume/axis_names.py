"""Names of the ends of axes: letters of a patient where an image tells how it lies, else the names of its axes."""

from __future__ import annotations

from app.model.volume.slices import AXES, Slices
from cpm_core.image.image import Image

Ends = tuple[str, str]
"""What is written where an axis begins, and where it ends."""


def ends_of(image: Image) -> tuple[Ends, Ends, Ends]:
    """The ends of the axes (plane, row, column) of a volume, or of the volume that an image is a plane of."""
    if image.geometry is not None:
        return image.geometry.ends
    plane, row, column = (("", name) for name in AXES)
    return plane, row, column


def edges_of(whole: Image, slices: Slices | None) -> tuple[Ends, Ends] | None:
    """What is written at the top and bottom, and at the left and right, of an image or of a slice of a volume.

    None for an image that does not tell how it lies.
    """
    if slices is None and whole.geometry is None:
        return None
    axis = 0 if slices is None else slices.axis
    down, right = (ends for index, ends in enumerate(ends_of(whole)) if index != axis)
    return down, right
