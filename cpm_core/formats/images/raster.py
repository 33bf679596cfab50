"""Common pictures: PNG, JPEG, BMP, PNM, GIF, WebP and JPEG 2000, read by Pillow."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
from numpy.typing import NDArray

from cpm_core.formats.images import resolution
from cpm_core.formats.images.decoded import (
    ORIENTATION_TAG,
    Decoded,
    UnreadableError,
    check_size,
    from_samples,
    upright,
)

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
_WITH_ALPHA = ("LA", "PA", "RGBA", "RGBa")
_PIXELS_A_METER = 1 / 0.0254


def read(path: Path) -> Decoded:
    """Read a picture, of an animation the first frame.

    Raises
    ------
    UnreadableError
        When the file is not such a picture, or too large. Damaged files raise any exception of the decoder.
    """
    with opened(path) as picture:
        return shown(picture, path.name)


@contextmanager
def opened(path: Path) -> Iterator[PIL.Image.Image]:
    """A picture, of which its size is known; see `read`."""
    try:
        with PIL.Image.open(path, formats=_DECODERS) as picture:
            yield picture
    except PIL.UnidentifiedImageError:
        raise UnreadableError(
            f"{path.name} is not an image of a known kind, or its beginning is damaged: choose a sound PNG, TIFF or "
            "JPEG file."
        ) from None
    except PIL.Image.DecompressionBombError:
        raise UnreadableError(f"{path.name} has far too many pixels: crop it or make it smaller first.") from None


def pixels(picture: PIL.Image.Image) -> Decoded:
    """Gray levels of an opened picture, of 16-bit pictures in full."""
    notes = list(_depth_notes(picture))
    largest = _declared_maximum(picture)
    mode = picture.mode
    if mode == "1":
        values: NDArray[Any] = np.array(picture.convert("L"))
        notes.append("Black and white were read as 0 and 255.")
    elif mode == "L" and "transparency" not in picture.info:
        values = np.array(picture)
        if largest not in (None, 255):
            values = np.rint(values * (largest / 255.0))
    elif mode == "F" or mode.startswith("I"):
        values = np.array(picture)
        if mode == "I" and largest not in (None, 65535):
            values = np.rint(values * (largest / 65535.0))
    elif mode in _WITH_ALPHA or "transparency" in picture.info:
        samples = np.array(picture.convert("RGBA"))
        channels = 1 if mode in ("L", "LA") else 3
        return from_samples(samples[..., :channels], samples[..., 3], tuple(notes))
    else:
        return from_samples(np.array(picture.convert("RGB")), notes=tuple(notes))
    return Decoded(values, notes=tuple(notes))


def shown(picture: PIL.Image.Image, name: str, alone: bool = False) -> Decoded:
    """The frame at which an opened picture is, upright; unless it stands `alone`, with a note on further ones."""
    check_size(name, picture.height, picture.width)
    decoded = pixels(picture)
    spacing, unit = _spacing(picture)
    turn = _orientation(picture)
    frames = ("Only its first frame was taken.",) if not alone and _has_second_frame(picture) else ()
    return upright(replace(decoded, spacing=spacing, unit=unit, notes=(*decoded.notes, *frames)), turn)


def _tile_arguments(picture: PIL.Image.Image) -> tuple[Any, ...]:
    """Arguments that Pillow passes to its decoder; empty when there are none."""
    tiles = getattr(picture, "tile", None) or [("", None, 0, ())]
    arguments = tiles[0][3]
    return arguments if isinstance(arguments, tuple) else (arguments,)


def _depth_notes(picture: PIL.Image.Image) -> tuple[str, ...]:
    """Note that Pillow cuts 16-bit color down to 8 bits."""
    arguments = _tile_arguments(picture)
    deep_color = picture.mode in ("RGB", "RGBA") and (
        (arguments and ";16" in str(arguments[0]))
        or (picture.format == "PPM" and (_declared_maximum(picture) or 0) > 255)
    )
    return ("Its 16 bits a color were cut down to 8.",) if deep_color else ()


def _declared_maximum(picture: PIL.Image.Image) -> int | None:
    """Maximum value that the header of a portable map declares; Pillow scales the values to another one."""
    arguments = _tile_arguments(picture)
    if picture.format == "PPM" and len(arguments) == 2 and isinstance(arguments[1], int) and arguments[1] > 0:
        return arguments[1]
    return None


def _spacing(picture: PIL.Image.Image) -> resolution.Spacing:
    """Pixel size, which among these formats only PNG states in a unit of length."""
    density = picture.info.get("dpi")
    if picture.format != "PNG" or density is None:
        return resolution.UNKNOWN
    return resolution.from_density(float(density[1]) * _PIXELS_A_METER, float(density[0]) * _PIXELS_A_METER)


def _orientation(picture: PIL.Image.Image) -> int:
    try:
        return int(picture.getexif().get(ORIENTATION_TAG, 1))
    except Exception:  # Pillow raises exceptions of any kind on broken camera data; the pixels are valid all the same
        return 1


def _has_second_frame(picture: PIL.Image.Image) -> bool:
    try:
        picture.seek(1)
    except EOFError:
        return False
    return True
