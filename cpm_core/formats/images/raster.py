"""Common pictures (PNG, JPEG, BMP, PNM, GIF, WebP, JPEG 2000), read by Pillow, animated ones frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
from numpy.typing import NDArray

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.decoded import (
    ORIENTATION_TAG,
    Decoded,
    check_size,
    from_bands,
    from_samples,
    upright,
)
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.stack import Stack, joined

READS = {
    ".png": "PNG picture",
    ".jpg": "JPEG picture",
    ".jpeg": "JPEG picture",
    ".bmp": "BMP picture",
    ".pbm": "portable bitmap",
    ".pgm": "portable gray map",
    ".ppm": "portable color map",
    ".pnm": "portable any map",
    ".gif": "GIF picture",
    ".webp": "WebP picture",
    ".jp2": "JPEG 2000 picture",
}

# A list of its own, because other decoders of Pillow start external programs or read documents.
_DECODERS = ("PNG", "JPEG", "BMP", "DIB", "PPM", "GIF", "WEBP", "JPEG2000")
_PIXELS_A_METER = 1 / 0.0254

_TURNED = (b"eXIf", b"Raw profile type exif", b"XML:com.adobe.xmp")
"""What begins the parts of a PNG that can state how it is turned."""

_END = 1 << 18
"""Bytes before and behind the pixels of a PNG in which these parts are looked for."""


def reads(_head: bytes, _path: Path) -> bool:
    """Always true: this reader is the last one, and Pillow recognizes the format itself."""
    return True


def stack(path: Path, _reading: Reading) -> Stack:
    """Open a picture, whose frames are points in time."""
    name = printable(path.name)
    with _opened(path) as picture:
        check_size(name, picture.height, picture.width)
        frames, turn = int(getattr(picture, "n_frames", 1)), _orientation(picture, path)
        spacing, unit = resolution.UNKNOWN
        density = picture.info.get("dpi")
        if frames == 1 and picture.format == "PNG" and density is not None:  # of these formats only PNG has a unit
            along = (float(density[1]) * _PIXELS_A_METER, float(density[0]) * _PIXELS_A_METER)
            spacing, unit = resolution.from_density(*along)
        order = -1 if turn in range(5, 9) else 1  # rows and columns are swapped
        (rows, columns), (row, col) = picture.size[::-order], spacing[::order]

    def take(time: int, _channel: int, _first: int, _end: int) -> Decoded:
        with _opened(path) as picture:
            picture.seek(time)
            return joined([upright(_pixels(picture, path), turn)])

    return Stack(name, (1, rows, columns), take, 4.0, frames, spacing=(row, row, col), unit=unit, word="frame")


@contextmanager
def _opened(path: Path) -> Iterator[PIL.Image.Image]:
    """A picture of which only the header has been read."""
    try:
        with PIL.Image.open(path, formats=_DECODERS) as picture:
            yield picture
    except PIL.Image.DecompressionBombError:
        raise UnreadableError(f"{path.name} has far too many pixels: crop it or make it smaller first.") from None


def _orientation(picture: PIL.Image.Image, path: Path) -> int:
    """How an opened picture is turned, by its camera."""
    if picture.format == "PNG":  # Pillow unpacks it to learn what follows its pixels
        with path.open("rb") as file:
            ends = file.read(_END)
            file.seek(max(file.tell(), path.stat().st_size - _END))
            ends += file.read()
        if not any(mark in ends for mark in _TURNED):
            return 1
    try:
        return int(picture.getexif().get(ORIENTATION_TAG, 1))
    except Exception:  # Pillow raises exceptions of any kind on broken camera data; the pixels are valid all the same
        return 1


def _pixels(picture: PIL.Image.Image, path: Path) -> Decoded:
    """Gray levels of an opened picture, in full depth where Pillow does not shorten them."""
    tiles: Any = getattr(picture, "tile", None) or [("", None, 0, ("",))]
    arguments = tiles[0][3] if isinstance(tiles[0][3], tuple) else (tiles[0][3],)  # of the decoder: how it is stored
    kind, mode, alpha = str((*arguments, "")[0]), picture.mode, picture.has_transparency_data
    declared = None  # the maximum that the header of a portable map declares; Pillow scales the values to another one
    if picture.format == "PPM" and len(arguments) == 2 and isinstance(arguments[1], int) and arguments[1] > 0:
        declared = arguments[1]
    whole = getattr(picture, "n_frames", 1) == 1 and not picture.info.get("interlace")
    deep = whole and kind in ("RGB;16B", "RGBA;16B", "LA;16B")
    if picture.format == "JPEG2000" or deep:
        return _unpacked(path, "png" if deep else "jpeg2k")
    # the same pixels sooner, since Pillow takes the interpreter's lock for each few of them; it knows what is wrong
    # with a JPEG without its end, of which other decoders are silent
    if picture.format == "JPEG" and mode in ("L", "RGB") and path.read_bytes().endswith(b"\xff\xd9"):
        return _unpacked(path, "jpeg8")
    if picture.format == "PNG" and whole and kind == mode and mode in ("L", "RGB") and not alpha:
        return _unpacked(path, "png")
    if mode == "1":
        return Decoded(np.array(picture.convert("L")), notes=("Black and white were read as 0 and 255.",))
    if (mode == "L" and not alpha) or mode == "F" or mode.startswith("I"):
        values: NDArray[Any] = np.array(picture)
        if declared is not None and mode in ("L", "I"):
            values = np.rint(values * (declared / (255 if mode == "L" else 65535)))
        return Decoded(values)
    if alpha:
        samples = np.array(picture.convert("RGBA"))
        gray = mode in ("L", "LA")
        return from_samples(samples[..., :1], samples[..., 3]) if gray else from_bands(samples)
    notes = ("Its 16 bits a color were cut down to 8.",) if (declared or 0) > 255 or ";16" in kind else ()
    return from_samples(np.array(picture.convert("RGB")), notes=notes)


def _unpacked(path: Path, kind: str) -> Decoded:
    """A picture by another decoder than that of Pillow, which takes only the higher bits of deep ones."""
    import imagecodecs  # only here, because it takes long to import

    samples = np.asarray(getattr(imagecodecs, f"{kind}_decode")(path.read_bytes()))
    if samples.ndim == 2:
        return Decoded(samples)
    if samples.shape[-1] == 2:
        return from_samples(samples[..., :1], samples[..., 1])
    return from_bands(samples)
