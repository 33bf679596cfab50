"""Decoded: the pixels of a file before they become an `Image`, upright and reduced to gray levels."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.image.colors import Colors
from cpm_core.image.geometry import Geometry

MAXIMUM_PIXELS = 2**26
"""Most pixels of an image; the field of a larger one exceeds the memory of a common computer."""

WEIGHTS = (0.2125, 0.7154, 0.0721)
"""Share of red, green and blue in the luminance (ITU-R BT.709)."""

_BLOCK = 2**18
"""Pixels whose colors are computed at once; those of the whole image would take many times its memory."""

LUMINANCE_NOTE = "Color was turned into luminance."

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
    values : ndarray, shape (H, W) or (P, H, W)
        Gray levels in the type of the file.
    spacing : tuple of float
        Size of a pixel along each axis, in `unit`.
    unit : str or None
        Unit of `spacing`; None when the file does not give it.
    notes : tuple of str
        What was changed while reading.
    colors : Colors or None
        Red, green and blue of each pixel; None where the file is gray.
    geometry : Geometry or None
        Where it lies in space; None when the file does not tell.
    """

    values: NDArray[Any]
    spacing: tuple[float, ...] = (1.0, 1.0)
    unit: str | None = None
    notes: tuple[str, ...] = ()
    colors: Colors | None = None
    geometry: Geometry | None = None


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


def from_samples(
    samples: NDArray[Any], alpha: NDArray[Any] | None = None, notes: tuple[str, ...] = (), white: float | None = None
) -> Decoded:
    """Reduce the samples of each pixel to its gray level.

    Parameters
    ----------
    samples : ndarray, shape (H, W, 1) or (H, W, 3)
        Gray, or red, green and blue.
    alpha : ndarray, shape (H, W), optional
        Opacity from 0 to the full scale of its type. Transparent parts become white, as on paper.
    notes : tuple of str, optional
        What was changed before.
    white : float, optional
        Value of white; by default that of the type of `samples`.

    Returns
    -------
    Decoded
        Gray levels in the range of `samples`, of opaque gray samples unchanged, and the channels of colored ones.
    """
    said, count, shape = list(notes), samples.shape[-1], samples.shape[:2]
    alike = all(np.array_equal(samples[..., 0], samples[..., other]) for other in range(1, count))
    white = full_scale(samples) if white is None else white
    if not alike:
        said.append(LUMINANCE_NOTE)
    elif count > 1:
        said.append("Its three color channels are the same; one was taken.")
    flat = (samples[..., :1] if alike else samples).reshape(-1, 1 if alike else count)
    clear = None
    if alpha is not None and np.any(alpha != full_scale(alpha)):
        said.append("Transparent parts were laid on white.")
        clear = alpha.reshape(-1, 1)
    if alike and clear is None:
        return Decoded(samples[..., 0], notes=tuple(said))
    gray = np.empty(len(flat))
    colors = None if alike else np.empty(flat.shape, np.uint8)
    most = 1.0 if clear is None else full_scale(clear)
    for first in range(0, len(flat), _BLOCK):
        place = slice(first, first + _BLOCK)
        part = flat[place]
        if clear is not None:
            opacity = clear[place] / most
            part = part * opacity + white * (1.0 - opacity)
        gray[place] = part[:, 0] if colors is None else luminance(part)
        if colors is not None:
            colors[place] = part if part.dtype == np.uint8 else _bytes_of(part, white)
    shown = None if colors is None else Colors(colors.reshape(*shape, count), white)
    return Decoded(gray.reshape(shape), notes=tuple(said), colors=shown)


def _bytes_of(samples: NDArray[Any], white: float) -> NDArray[np.float64]:
    """Samples from 0 to white as whole numbers from 0 to 255."""
    shares = np.asarray(np.clip(samples, 0.0, white), np.float64) / white
    return np.rint(np.nan_to_num(255.0 * shares))


def luminance(channels: NDArray[Any]) -> NDArray[np.float64]:
    """Luminance of red, green and blue, which are the last axis, in their range."""
    gray = np.zeros(channels.shape[:-1])
    for channel, weight in enumerate(WEIGHTS):
        gray += np.float64(weight) * channels[..., channel]  # of half precision too
    return gray


def upright(decoded: Decoded, orientation: int) -> Decoded:
    """Rotate and mirror `decoded` by its orientation tag (1 to 8); unknown values leave it unchanged."""
    if orientation not in _TURNS:
        return decoded
    swap, flip_rows, flip_columns = _TURNS[orientation]
    spacing = decoded.spacing[::-1] if swap else decoded.spacing

    def turned(pixels: NDArray[Any]) -> NDArray[Any]:
        pixels = pixels.swapaxes(0, 1) if swap else pixels
        return np.ascontiguousarray(pixels[:: -1 if flip_rows else 1, :: -1 if flip_columns else 1])

    colors = decoded.colors and replace(decoded.colors, samples=turned(decoded.colors.samples))
    notes = (*decoded.notes, "It was turned upright by its orientation tag.")
    return replace(decoded, values=turned(decoded.values), spacing=spacing, notes=notes, colors=colors)
