"""Common pictures: PNG, JPEG, BMP, PNM, GIF, WebP and JPEG 2000, read by Pillow."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from io import BytesIO
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
_CODESTREAM, _DEPTH_AT, _JPEG_2000_HEADER = b"\xff\x4f\xff\x51", 42, 2**16
"""How the header of JPEG 2000 begins, where behind it the bits of a number stand, and where it ends at most."""

_DEEP = 2**16 - 1
"""White of 16 bits."""


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
        with path.open("rb") as stream:
            is_jpeg = stream.read(3) == b"\xff\xd8\xff"
        if is_jpeg:
            raise UnreadableError(
                f"{path.name} is a JPEG of a kind that is not read (of 12 bits, or without loss), or is damaged: save "
                "it again as TIFF or PNG."
            ) from None
        raise
    except PIL.Image.DecompressionBombError:
        raise UnreadableError(f"{path.name} has far too many pixels: crop it or make it smaller first.") from None


def pixels(picture: PIL.Image.Image) -> Decoded:
    """Gray levels of an opened picture, of 16-bit pictures in full."""
    deep = _deep_colors(picture)
    if deep is not None:
        return deep
    notes = list(_depth_notes(picture))
    largest = _declared_maximum(picture)
    mode, clear, step = picture.mode, picture.info.get("transparency"), _step(picture)
    if mode == "1":
        values: NDArray[Any] = np.array(picture.convert("L"))
        notes.append("Black and white were read as 0 and 255.")
    elif mode == "L" and clear is None:
        values = np.array(picture)
        if largest not in (None, 255):
            values = np.rint(values * (largest / 255.0))
    elif mode == "F" or mode.startswith("I"):
        values = np.array(picture)
        if mode == "I" and largest not in (None, 65535):
            values = np.rint(values * (largest / 65535.0))
    elif mode == "L" and picture.format == "PNG":
        values = np.array(picture)
    elif mode in _WITH_ALPHA or clear is not None:
        samples = np.array(picture.convert("RGBA"))
        channels = 1 if mode in ("L", "LA") else 3
        return from_samples(samples[..., :channels], samples[..., 3], tuple(notes))
    else:
        return from_samples(np.array(picture.convert("RGB")), notes=tuple(notes))
    if picture.format == "JPEG2000":
        bits, signed = _stored_bits(picture)
        wide = values.dtype.itemsize * 8
        values = (values >> max(wide - bits, 0)).astype(np.int64) - (2 ** (bits - 1) if signed else 0)
    if picture.format == "PNG" and isinstance(clear, int):
        return _without_one(values[..., np.newaxis], np.array([clear * step]), tuple(notes))
    return Decoded(values, notes=tuple(notes))


def _step(picture: PIL.Image.Image) -> int:
    """Gray levels between neighboring ones of a PNG, which has up to eight bits a pixel that Pillow widens to eight."""
    return {"1": 255, "L;2": 85, "L;4": 17}.get(_raw_kind(picture), 1)


def _raw_kind(picture: PIL.Image.Image) -> str:
    """How Pillow calls the pixels that a picture stores."""
    return str((*_tile_arguments(picture), "")[0])


def _without_one(samples: NDArray[Any], clear: NDArray[Any], notes: tuple[str, ...] = ()) -> Decoded:
    """Pixels of a PNG of which those with one gray level or color are transparent."""
    white = 255 if samples.dtype == np.uint8 else _DEEP
    opacity = np.where((samples == clear).all(axis=-1), 0.0, 1.0)
    return from_samples(samples, opacity, notes, float(white))


def _deep_colors(picture: PIL.Image.Image) -> Decoded | None:
    """A PNG with 16 bits a color, of which Pillow takes the higher ones; None for another picture or a film."""
    kind = _raw_kind(picture)
    if picture.format != "PNG" or kind not in ("RGB;16B", "RGBA;16B", "LA;16B") or getattr(picture, "n_frames", 1) > 1:
        return None
    content = Path(picture.filename).read_bytes()  # type: ignore[attr-defined]
    if kind == "LA;16B":  # two numbers of two bytes each lie as four of one byte do
        with PIL.Image.open(BytesIO(_with_header(content, depth=8, color=6))) as bytewise:
            parts = np.array(bytewise)
        high, low = parts[..., ::2], parts[..., 1::2]
    else:
        high = np.array(picture)
        with PIL.Image.open(BytesIO(content)) as again:
            # of numbers that had their lower byte first, this would be the higher one
            again.tile = [(*again.tile[0][:3], kind.replace(";16B", ";16L"))]  # type: ignore[list-item]
            low = np.array(again)
    samples = high.astype(np.uint16) << 8 | low
    clear = picture.info.get("transparency")
    if clear is not None:
        return _without_one(samples, np.asarray(clear))
    if samples.shape[-1] == 3:
        return from_samples(samples)
    return from_samples(samples[..., :-1], samples[..., -1])


def _with_header(png: bytes, depth: int, color: int) -> bytes:
    """A PNG that says it had another depth and kind of color."""
    header = png[12:24] + bytes((depth, color)) + png[26:29]
    return png[:12] + header + zlib.crc32(header).to_bytes(4, "big") + png[33:]


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


def _stored_bits(picture: PIL.Image.Image) -> tuple[int, bool]:
    """Bits of a number of JPEG 2000, which Pillow widens to all of its type, and whether there are negative ones."""
    with Path(picture.filename).open("rb") as stream:  # type: ignore[attr-defined]
        head = stream.read(_JPEG_2000_HEADER)
    begin = head.find(_CODESTREAM)
    if begin < 0 or begin + _DEPTH_AT >= len(head):
        raise ValueError("the header has no end")
    told = head[begin + _DEPTH_AT]
    return (told & 0x7F) + 1, bool(told & 0x80)


def _depth_notes(picture: PIL.Image.Image) -> tuple[str, ...]:
    """Note that Pillow cuts deep color down to 8 bits."""
    if picture.format == "JPEG2000" and picture.mode in ("LA", "RGB", "RGBA"):
        bits, _ = _stored_bits(picture)
        return (f"Its {bits} bits a color were cut down to 8.",) if bits > 8 else ()
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
