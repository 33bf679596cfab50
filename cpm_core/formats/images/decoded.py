"""Decoded: the pixels of a file before they become an `Image`, upright and reduced to gray levels."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAXIMUM_PIXELS = 2**26
"""Most pixels of an image; the field of a larger one exceeds the memory of a common computer."""

WEIGHTS = (0.2125, 0.7154, 0.0721)
"""Share of red, green and blue in the luminance (ITU-R BT.709)."""

ORIENTATION_TAG = 274
"""Number of the orientation tag of EXIF and TIFF, which cameras and scanners write."""

# For each value of the tag whether to swap rows and columns, then to flip rows, then to flip columns.
_TURNS = {
    2: (False, False, True),
    3: (False, True, True),
    4: (False, True, False),
    5: (True, False, False),
    6: (True, False, True),
    7: (True, True, True),
    8: (True, True, False),
}


class UnreadableError(ValueError):
    """A file cannot be used; the message is a sentence for users."""


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
        Unit of `spacing`; None when the file does not give it.
    notes : tuple of str
        What was changed while reading.
    """

    values: NDArray[Any]
    spacing: tuple[float, float] = (1.0, 1.0)
    unit: str | None = None
    notes: tuple[str, ...] = ()


def check_size(name: str, rows: int, columns: int) -> None:
    """Raise UnreadableError for an image of more than `MAXIMUM_PIXELS` pixels, before they are unpacked."""
    if rows * columns > MAXIMUM_PIXELS:
        side = math.isqrt(MAXIMUM_PIXELS)
        raise UnreadableError(
            f"{name} is {rows} x {columns} px, more than {side} x {side}: crop it or make it smaller first."
        )


def full_scale(values: NDArray[Any]) -> float:
    """Gray level of white: the largest value of an integer type, else 1 or the largest value that occurs."""
    if values.dtype.kind == "b":
        return 1.0
    if values.dtype.kind in "ui":
        return float(np.iinfo(values.dtype).max)
    return max(1.0, float(np.max(values, initial=1.0)))


def to_gray(samples: NDArray[Any], alpha: NDArray[Any] | None = None) -> tuple[NDArray[Any], tuple[str, ...]]:
    """Reduce the samples of each pixel to its gray level.

    Parameters
    ----------
    samples : ndarray, shape (H, W, 1) or (H, W, 3)
        Gray, or red, green and blue.
    alpha : ndarray, shape (H, W), optional
        Opacity from 0 to the full scale of its type. Transparent parts become white, as on paper.

    Returns
    -------
    values : ndarray, shape (H, W)
        Gray levels in the range of `samples`; opaque gray samples are returned unchanged.
    notes : tuple of str
        What was changed.
    """
    notes: list[str] = []
    first = samples[..., 0]
    if samples.shape[-1] == 1:
        gray = first
    elif np.array_equal(first, samples[..., 1]) and np.array_equal(first, samples[..., 2]):
        gray = first
        notes.append("Its three color channels are the same; one was taken.")
    else:
        gray = samples.astype(np.float64) @ np.array(WEIGHTS)
        notes.append("Color was turned into luminance.")
    if alpha is not None:
        opacity = alpha.astype(np.float64) / full_scale(alpha)
        if np.any(opacity != 1.0):
            gray = gray * opacity + full_scale(samples) * (1.0 - opacity)
            notes.append("Transparent parts were laid on white.")
    return gray, tuple(notes)


def upright(decoded: Decoded, orientation: int) -> Decoded:
    """Rotate and mirror `decoded` by its orientation tag (1 to 8); unknown values leave it unchanged."""
    if orientation not in _TURNS:
        return decoded
    swap, flip_rows, flip_columns = _TURNS[orientation]
    values, spacing = decoded.values, decoded.spacing
    if swap:
        values, spacing = values.T, (spacing[1], spacing[0])
    if flip_rows:
        values = values[::-1]
    if flip_columns:
        values = values[:, ::-1]
    note = "It was turned upright by its orientation tag."
    return replace(decoded, values=np.ascontiguousarray(values), spacing=spacing, notes=(*decoded.notes, note))
