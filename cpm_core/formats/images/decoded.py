"""Decoded: what a reader took out of a file, before it becomes an `Image`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAXIMUM_PIXELS = 2**26
"""Most pixels an image may have; the field of more would not fit the memory of a common computer."""


class UnreadableError(ValueError):
    """A file cannot be used, for a reason that is already a sentence for people."""


@dataclass(frozen=True, eq=False)
class Decoded:
    """Gray levels of a file, not yet checked.

    Attributes
    ----------
    values : ndarray, shape (H, W)
        Gray levels in the type of the file.
    spacing : tuple of float
        Size of a pixel along (row, col), in `unit`.
    unit : str or None
        Unit of `spacing`; None when the file does not tell.
    notes : tuple of str
        What was changed while reading.
    """

    values: NDArray[Any]
    spacing: tuple[float, float] = (1.0, 1.0)
    unit: str | None = None
    notes: tuple[str, ...] = ()


def check_size(name: str, rows: int, columns: int) -> None:
    """Refuse an image that is too large before its pixels are unpacked.

    Raises
    ------
    UnreadableError
        When it has more than `MAXIMUM_PIXELS` pixels.
    """
    if rows * columns > MAXIMUM_PIXELS:
        side = math.isqrt(MAXIMUM_PIXELS)
        raise UnreadableError(
            f"{name} is {rows} x {columns} px, more than {side} x {side}: crop it or make it smaller first."
        )


def full_scale(values: NDArray[Any]) -> float:
    """Gray level of white: the largest value of an integer type, else 1 or the largest value there is."""
    if values.dtype.kind == "b":
        return 1.0
    if values.dtype.kind in "ui":
        return float(np.iinfo(values.dtype).max)
    return max(1.0, float(np.max(values, initial=1.0)))
