"""Decoded images: pixels of a file before they become an `Image`, upright and reduced to gray levels."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.image.colors import Colors, reduce_to_gray
from cpm_core.image.geometry import Geometry
from cpm_core.numerics.types import Numbers, Sides, Texts, record

MAXIMUM_PIXELS = 2**26
"""Largest number of pixels of an image; the field of a larger one exceeds the memory of a common computer."""

ORIENTATION_TAG = 274
"""Number of the orientation tag of EXIF and TIFF, which cameras and scanners write."""


@record
class DecodedImage:
    """Gray levels of a file, not checked yet.

    Attributes
    ----------
    values : ndarray, shape (H, W) or (P, H, W)
        Gray levels in the type of the file.
    spacing : tuple of float
        Size of a pixel along each axis, in `unit`.
    unit : str or None
        Unit of `spacing`; None when the file does not give it.
    notes : tuple of str
        Changes made while reading.
    colors : Colors or None
        Red, green and blue of each pixel; None for a gray file.
    hounsfield : bool or None
        Whether gray levels are Hounsfield units; None if the file does not state it.
    geometry : Geometry or None
        Position in space; None when the file does not state it.
    finer : tuple
        As in `Image.finer`.
    window : tuple of float or None
        As in `Image.window`.
    """

    values: Numbers
    spacing: Sides = (1.0, 1.0)
    unit: str | None = None
    notes: Texts = ()
    colors: Colors | None = None
    geometry: Geometry | None = None
    hounsfield: bool | None = None
    finer: tuple[Any, ...] = ()
    window: tuple[float, float] | None = None


def check_pixel_count(name: str, rows: int, columns: int) -> None:
    """Raise UnreadableError for an image of more than `MAXIMUM_PIXELS` pixels, before it is unpacked."""
    if rows * columns > MAXIMUM_PIXELS:
        side = math.isqrt(MAXIMUM_PIXELS)
        raise UnreadableError(
            f"{name} is {rows} x {columns} px, more than {side} x {side}: crop it or make it smaller first."
        )


def decode_samples(
    samples: Numbers, alpha: Numbers | None = None, notes: Texts = (), white: float | None = None
) -> DecodedImage:
    """Reduce samples to gray levels and keep their colors; see `reduce_to_gray`.

    Parameters
    ----------
    samples : ndarray, shape (..., W, C)
        Samples of each pixel along the last axis.
    alpha : ndarray, shape (..., W), optional
        Opacity from 0 to the full scale of its type.
    notes : tuple of str
        Changes made before.
    white : float, optional
        Level of white; by default that of the type.

    Returns
    -------
    DecodedImage
        Gray levels of shape (..., W), colors, and notes.
    """
    *shape, width, count = samples.shape
    values, colors, said = reduce_to_gray(
        samples.reshape(-1, width, count), None if alpha is None else alpha.reshape(-1, width), white
    )
    colors = colors and replace(colors, samples=colors.samples.reshape(*shape, width, 3))
    return DecodedImage(values.reshape(*shape, width), notes=(*notes, *said), colors=colors)


def decode_bands(samples: Numbers) -> DecodedImage:
    """Reduce samples of shape (..., 3) or (..., 4), red, green, blue and perhaps opacity, to gray levels."""
    return decode_samples(samples[..., :3], samples[..., 3] if samples.shape[-1] == 4 else None)


def decode_voxels(voxels: Numbers) -> DecodedImage:
    """Decode voxels as nibabel gives them: gray levels, or red, green and blue as fields of their type."""
    names = voxels.dtype.names
    return decode_bands(np.stack([voxels[name] for name in names], axis=-1)) if names else DecodedImage(voxels)


def rotate_upright(decoded: DecodedImage, orientation: int) -> DecodedImage:
    """Rotate and mirror an image by its orientation tag (1 to 8); unknown tags leave it unchanged."""
    if orientation not in range(2, 9):
        return decoded
    swap, turn = orientation > 4, (orientation - 1) % 4  # rows and columns are swapped first
    flip_rows, flip_columns = turn in (2, 3), turn in (1, 2)
    spacing = decoded.spacing[::-1] if swap else decoded.spacing

    def rotate_pixels(pixels: Numbers) -> Numbers:
        pixels = pixels.swapaxes(0, 1) if swap else pixels
        return np.ascontiguousarray(pixels[:: -1 if flip_rows else 1, :: -1 if flip_columns else 1])

    colors = decoded.colors and replace(decoded.colors, samples=rotate_pixels(decoded.colors.samples))
    notes = (*decoded.notes, "It was turned upright by its orientation tag.")
    return replace(decoded, values=rotate_pixels(decoded.values), spacing=spacing, notes=notes, colors=colors)
