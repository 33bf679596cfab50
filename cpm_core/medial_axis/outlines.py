"""Outlines of objects that are given, as closed contours or as a mask, instead of found in an image."""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.contours.contour import Contour, Contours
from cpm_core.numerics import polyline
from cpm_core.numerics.real_numbers import as_real_array
from cpm_core.numerics.types import Array, Extent, Integers, Line, Mask, frozen


@frozen
class SkeletonTarget:
    """Objects or outlines that have a skeleton in place of what is found in an image; nothing for the image itself.

    Attributes
    ----------
    objects : tuple of int
        Numbers of segmented objects.
    contours : tuple of lines
        Closed outlines, as vertices (row, col) [px].
    """

    objects: Integers = ()
    contours: tuple[Line, ...] = ()


def closed_outlines(within: Contours | ArrayLike, shape: Extent) -> tuple[Contour, ...]:
    """Collect the closed outlines among contours, or trace them in a mask of the shape of the image.

    Raises
    ------
    ValueError
        When nothing is enclosed, or the mask does not fit the image.
    """
    if isinstance(within, Sequence) and all(isinstance(one, Contour) for one in within):
        found = tuple(one for one in within if isinstance(one, Contour) and one.encloses_area)
    else:
        mask = check_mask(within, shape)
        from skimage.measure import find_contours  # noqa: PLC0415 - takes long to load

        padded = np.pad(mask.astype(float), 1)
        found = tuple(Contour(line[:-1] - 1.0, closed=True) for line in find_contours(padded, 0.5))  # type: ignore[no-untyped-call]
    if not found:
        raise ValueError("there is no closed outline to find the skeleton of: select an object or a closed contour.")
    return found


def check_mask(within: Contours | ArrayLike, shape: Extent) -> Mask:
    """Check that a mask has the shape of an image or a volume, else raise ValueError."""
    if isinstance(within, Sequence) and any(isinstance(one, Contour) for one in within):
        raise ValueError("within contains contours, which lie in a plane: give a mask in a volume.")
    mask = as_real_array(cast("ArrayLike", within)) != 0.0
    if mask.shape != shape:
        raise ValueError(f"within has the shape {mask.shape}, but the image {shape}: give a mask of that shape.")
    return mask


def is_inside_outlines(outlines: Contours, places: Array) -> Mask:
    """Return whether places, shape (N, 2) [px], lie inside an odd number of outlines: in objects, not in holes."""
    inside = np.zeros(len(places), bool)
    for outline in outlines:
        low, high = outline.points.min(axis=0), outline.points.max(axis=0)
        near = np.flatnonzero(((places >= low) & (places <= high)).all(axis=1))
        inside[near] ^= polyline.points_inside(outline.points, places[near])
    return inside
