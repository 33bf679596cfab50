"""A second image on the grid of a first one, by where both lie in space."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.image.drawing import KNOWN_UNITS
from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Single
from cpm_core.parameters.formatting import format_size

_GRID_TOLERANCE = 1e-4
"""Largest distance of two grids that count as the same [voxels]."""


_MIN_EQUAL_NEIGHBORS = 0.5
"""Share of the neighbors in and around the objects of a label map that are equal, at least."""


_LEAST_STEPS = 3
"""Number of levels with a common divisor, such as 0, 85, 170 and 255, from which on they are gray levels."""


def is_label_map(image: Image) -> bool:
    """Tell whether gray levels are numbers of objects: whole, mostly those of their neighbors, and no even steps.

    The level of the first pixel is that of the background, as white is in drawings.
    """
    levels = image.stored
    if image.colors is not None or levels.min() < 0 or (levels.dtype.kind == "f" and (levels % 1.0).any()):
        return False
    left, right, background = levels[..., :-1], levels[..., 1:], levels.flat[0]
    inside = (left != background) | (right != background)
    if not inside.any() or (left == right)[inside].mean() < _MIN_EQUAL_NEIGHBORS:
        return False
    step = np.gcd.reduce(levels.astype(np.int64), axis=None)
    return bool(step == 1 or levels.max() < _LEAST_STEPS * step)


def find_grid_mapping(image: Image, target: Image) -> Array:
    """Find the matrix from the pixels of a target to those of an image, shape (D + 1, D + 1).

    Where both volumes have a place in space, it decides. Otherwise images of one shape lie on each other, and others
    share their first pixel, if the size of a pixel is known of both.

    Raises
    ------
    ValueError
        When one is an image and the other a volume, or nothing tells how they lie.
    """
    if image.ndim != target.ndim:
        kinds = ("an image", "a volume")
        raise ValueError(
            f"{image.source} is {kinds[image.ndim - 2]}, but {target.source} is {kinds[target.ndim - 2]}: choose one "
            "of the same kind."
        )
    known = image.unit in KNOWN_UNITS and target.unit in KNOWN_UNITS
    factor = KNOWN_UNITS[target.unit or ""] / KNOWN_UNITS[image.unit or ""] if known else 1.0
    if image.ndim == 3 and image.geometry is not None and target.geometry is not None:
        there = np.diag([factor] * 3 + [1.0]) @ target.geometry.affine(target.spacing, "LPS")
        return np.linalg.inv(image.geometry.affine(image.spacing, "LPS")) @ there
    if image.shape == target.shape:
        return np.eye(image.ndim + 1)
    if not known:
        raise ValueError(
            f"{image.source} has {format_size(image.shape)} and {target.source} {format_size(target.shape)}, and "
            "nothing tells how they lie on each other: give both the size of a pixel, or use files that state it."
        )
    return np.diag([*(factor * np.array(target.spacing) / image.spacing), 1.0])


def resample_image(image: Image, mapping: Array, target: Image, first: int, end: int, *, nearest: bool) -> Single:
    """Sample an image at the pixels of a target, from plane (or row) `first` up to `end`.

    Parameters
    ----------
    image : Image
        The image.
    mapping : ndarray, shape (D + 1, D + 1)
        `find_grid_mapping` of both.
    target : Image
        The image whose grid is taken.
    first, end : int
        The part of its first axis.
    nearest : bool
        Whether the nearest gray level is taken, as labels need, instead of one between them.

    Returns
    -------
    ndarray of float32, shape (end - first, ...)
        The gray levels; NaN outside of the image.
    """
    turn, shift = mapping[:-1, :-1], mapping[:-1, -1] + mapping[:-1, 0] * first
    shape = (end - first, *target.shape[1:])
    moved = np.abs((mapping - np.eye(len(mapping))) @ (*target.shape, 1))
    if image.shape == target.shape and moved.max() <= _GRID_TOLERANCE:
        return image.stored[first:end].astype(np.float32)
    found = np.empty(shape, np.float32)
    scipy.ndimage.affine_transform(
        image.stored, turn, shift, shape, output=found, order=0 if nearest else 1, cval=np.nan
    )
    return found
