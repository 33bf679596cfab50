"""Checks of arrays and numbers that callers pass."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.numerics.types import Array
from cpm_core.parameters.formatting import quote_value

_REAL_TYPES = (int, float, np.integer, np.floating)
"""Types that count as real numbers."""

_MIN_VOXEL_SIDE = 1e-12
"""Least side of a voxel, in any unit."""

_MAX_VOXEL_SIDE = 1e12
"""Greatest side of a voxel, in any unit."""

MAX_SIDE_RATIO = 1000
"""Greatest ratio of two sides of a voxel."""


def as_real_array(values: ArrayLike) -> Array:
    """Return values of any shape in double precision, not copied if they are; raise ValueError for other types.

    NumPy's own conversion drops the imaginary parts.
    """
    try:
        given = np.asarray(values)
    except ValueError:
        raise ValueError(
            f"The values are {quote_value(values)}, whose lists differ in length: make them the same."
        ) from None
    if given.size and given.dtype.kind not in "buif":
        raise ValueError(f"The values are of type {given.dtype} but must be real numbers.")
    return given.astype(float, copy=False)


def check_rows(what: str, given: ArrayLike, axes: int, columns: str = "") -> Array:
    """Return points or vectors, one a row, shape (N, D); raise ValueError, which says what they are, for others.

    The error names the `columns`, by default the axes of an image or a volume.
    """
    rows = as_real_array(given)
    if rows.size == 0:
        return np.empty((0, axes))
    if rows.ndim != 2 or rows.shape[1] != axes:
        columns = columns or ("" if axes == 2 else "planes, ") + "rows and columns"
        raise ValueError(f"the {what} have the shape {rows.shape} but must be (N, {axes}), {columns}.")
    wrong = np.count_nonzero(~np.isfinite(rows))
    if wrong:
        raise ValueError(f"{wrong} coordinates of the {what} are not finite: leave these {what} out.")
    return rows


def as_positions(given: ArrayLike, axes: int) -> Array:
    """Return one position or several as an array, shape (N, D); raise ValueError for others."""
    return check_rows("positions", np.atleast_2d(as_real_array(given)), axes)


def check_finite_number(name: str, value: Any, fits: Callable[[float], bool], wanted: str) -> float:
    """Return a number as float; raise ValueError, which says what is wanted, unless it is finite and fits."""
    number = math.nan
    if issubclass(type(value), _REAL_TYPES):
        with suppress(OverflowError):  # of a whole number of some hundred digits
            number = float(value)
    if not (math.isfinite(number) and fits(number)):
        raise ValueError(f"{name} is {quote_value(value)} but must be {wanted}.")
    return number


def check_three_numbers(name: str, values: ArrayLike, positive: bool = False) -> Array:
    """Return three finite numbers along the axes of a volume, shape (3,); raise ValueError otherwise.

    With `positive` they must be above 0.
    """
    given = np.empty(0)
    with suppress(ValueError):
        given = as_real_array(values)
    if given.shape != (3,) or not np.isfinite(given).all() or (positive and not (given > 0.0).all()):
        kind = "three numbers above 0" if positive else "three finite numbers"
        raise ValueError(f"{name} is {quote_value(values)} but must be {kind}, (plane, row, col).")
    return given


def check_voxel_sides(name: str, values: ArrayLike) -> Array:
    """Return the sides of a voxel, shape (3,); raise ValueError unless areas and volumes in them make sense."""
    sides = check_three_numbers(name, values, positive=True)
    if not (sides.min() >= _MIN_VOXEL_SIDE and sides.max() <= _MAX_VOXEL_SIDE):
        raise ValueError(
            f"{name} is {quote_value(values)} but must be three numbers from {_MIN_VOXEL_SIDE:g} to "
            f"{_MAX_VOXEL_SIDE:g}, (plane, row, col): choose another unit."
        )
    if sides.max() > MAX_SIDE_RATIO * sides.min():
        raise ValueError(
            f"{name} is {quote_value(values)}, (plane, row, col), which makes a side of a voxel more than "
            f"{MAX_SIDE_RATIO} times as long as another: correct it."
        )
    return sides


def check_image_values(values: ArrayLike, least: int = 1) -> Array:
    """Return an image, shape (H, W) or (P, H, W), in double precision; raise ValueError unless it is finite.

    Each axis must have `least` pixels or more.
    """
    image = as_real_array(values)
    if image.ndim not in (2, 3) or min(image.shape) < least:
        raise ValueError(
            f"The values have the shape {image.shape}, but an image needs two axes or three, with {least} or more "
            "pixels along each."
        )
    low, high = float(image.min()), float(image.max())
    if not abs(low) + abs(high) <= sys.float_info.max:
        raise ValueError("The values hold NaN, infinite or far too large numbers: replace them first.")
    return image
