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
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.decoded import (
    ORIENTATION_TAG,
    DecodedImage,
    check_pixel_count,
    decode_bands,
    decode_samples,
    rotate_upright,
)
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.stack import Stack, stack_planes
from cpm_core.numerics.packages import has_package, require_package

FILE_KINDS = {
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

_PILLOW_FORMATS = ("PNG", "JPEG", "BMP", "DIB", "PPM", "GIF", "WEBP", "JPEG2000")
"""Formats that Pillow may decode; other decoders of it start external programs or read documents."""

_INCHES_PER_METER = 1 / 0.0254
"""Factor from dots per inch to pixels per meter."""

_ORIENTATION_MARKS = (b"eXIf", b"Raw profile type exif", b"XML:com.adobe.xmp")
"""Marks of the parts of a PNG that can state its orientation."""

_METADATA_SEARCH_SIZE = 1 << 18
"""Range at either end of a PNG in which these parts are searched [bytes]."""


def can_read(_head: bytes, _path: Path) -> bool:
    """Return True: this reader comes last, and Pillow recognizes the format itself."""
    return True


def open_image_file(path: Path, _reading: Reading) -> Stack:
    """Open a picture; its frames are points in time."""
    name = make_printable(path.name)
    with _open_picture(path) as picture:
        check_pixel_count(name, picture.height, picture.width)
        frames, turn = _count_frames(picture), _read_orientation(picture, path)
        spacing, unit = resolution.UNKNOWN_SPACING if frames > 1 else _read_spacing(picture)
        order = -1 if turn in range(5, 9) else 1  # rows and columns are swapped
        (rows, columns), (row, col) = picture.size[::-order], spacing[::order]

    def read_planes(time: int, _channel: int, _first: int, _end: int) -> DecodedImage:
        with _open_picture(path) as picture:
            picture.seek(time)
            return stack_planes([rotate_upright(_decode_picture(picture, path), turn)])

    return Stack(
        name, (1, rows, columns), read_planes, 4.0, frames, spacing=(row, row, col), unit=unit, plane_word="frame"
    )


@contextmanager
def _open_picture(path: Path) -> Iterator[PIL.Image.Image]:
    """Open a picture, reading only its header."""
    try:
        with PIL.Image.open(path, formats=_PILLOW_FORMATS) as picture:
            yield picture
    except PIL.Image.DecompressionBombError:
        raise UnreadableError(f"{path.name} has far too many pixels: crop it or make it smaller first.") from None


def _read_spacing(picture: PIL.Image.Image) -> resolution.Spacing:
    """Read the size of a pixel; among these formats only PNG states its unit, and JPEG the ratio of its sides."""
    info = picture.info
    if picture.format == "PNG" and "dpi" in info:
        columns, rows = (float(count) * _INCHES_PER_METER for count in info["dpi"])
    elif info.get("jfif_unit") == 0 or "aspect" in info:
        columns, rows = map(float, info.get("aspect") or info["jfif_density"])
    else:
        return resolution.UNKNOWN_SPACING
    return resolution.spacing_from_density(rows, columns)


def _count_frames(picture: PIL.Image.Image) -> int:
    """Count the frames of an open picture; what a phone adds to a photo, such as a preview, is none."""
    return 1 if picture.format == "MPO" else int(getattr(picture, "n_frames", 1))


def _read_orientation(picture: PIL.Image.Image, path: Path) -> int:
    """Read the orientation tag of an open picture."""
    if picture.format == "PNG":  # Pillow would unpack it to read what follows the pixels
        with path.open("rb") as file:
            ends = file.read(_METADATA_SEARCH_SIZE)
            file.seek(max(file.tell(), path.stat().st_size - _METADATA_SEARCH_SIZE))
            ends += file.read()
        if not any(mark in ends for mark in _ORIENTATION_MARKS):
            return 1
    try:
        return int(picture.getexif().get(ORIENTATION_TAG, 1))
    except Exception:  # Pillow raises exceptions of any kind on broken camera data, although the pixels are valid
        return 1


def _decode_picture(picture: PIL.Image.Image, path: Path) -> DecodedImage:
    """Decode the gray levels of an open picture, in full depth even where Pillow would reduce it."""
    tiles: Any = getattr(picture, "tile", None) or [("", None, 0, ("",))]
    arguments = (
        tiles[0][3] if isinstance(tiles[0][3], tuple) else (tiles[0][3],)
    )  # of the decoder: how pixels are stored
    kind, mode, alpha = str((*arguments, "")[0]), picture.mode, picture.has_transparency_data
    declared = None  # maximum in the header of a portable map; Pillow rescales the values
    if picture.format == "PPM" and len(arguments) == 2 and isinstance(arguments[1], int) and arguments[1] > 0:
        declared = arguments[1]
    whole = _count_frames(picture) == 1 and not picture.info.get("interlace")
    deep = whole and kind in ("RGB;16B", "RGBA;16B", "LA;16B")
    if deep or (picture.format == "JPEG2000" and (has_package("imagecodecs") or mode not in ("L", "RGB"))):
        return _decode_by_imagecodecs(path, "png" if deep else "jpeg2k")
    if mode in ("L", "RGB") and has_package("imagecodecs"):
        # the same pixels, but faster, since Pillow holds the interpreter's lock; a truncated JPEG is left to Pillow,
        # which reports it, unlike other decoders
        if picture.format == "JPEG" and path.read_bytes().endswith(b"\xff\xd9"):
            return _decode_by_imagecodecs(path, "jpeg8")
        if picture.format == "PNG" and whole and kind == mode and not alpha:
            return _decode_by_imagecodecs(path, "png")
    if mode == "1":
        return DecodedImage(np.array(picture.convert("L")), notes=("Black and white were read as 0 and 255.",))
    if (mode == "L" and not alpha) or mode == "F" or mode.startswith("I"):
        values: NDArray[Any] = np.array(picture)
        if declared is not None and mode in ("L", "I"):
            values = np.rint(values * (declared / (255 if mode == "L" else 65535)))
        return DecodedImage(values)
    if alpha:
        samples = np.array(picture.convert("RGBA"))
        gray = mode in ("L", "LA")
        return decode_samples(samples[..., :1], samples[..., 3]) if gray else decode_bands(samples)
    notes = ("Its 16 bits a color were cut down to 8.",) if (declared or 0) > 255 or ";16" in kind else ()
    return decode_samples(np.array(picture.convert("RGB")), notes=notes)


def _decode_by_imagecodecs(path: Path, kind: str) -> DecodedImage:
    """Decode a picture by imagecodecs; Pillow takes only the higher bits of deep ones."""
    require_package("imagecodecs", path.name)
    import imagecodecs  # only here, because it takes long to import

    samples = np.asarray(getattr(imagecodecs, f"{kind}_decode")(path.read_bytes()))
    if samples.ndim == 2:
        return DecodedImage(samples)
    if samples.shape[-1] == 2:
        return decode_samples(samples[..., :1], samples[..., 1])
    return decode_bands(samples)
