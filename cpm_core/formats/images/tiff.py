"""TIFF: microscopy and scientific images of any depth, with the size of a pixel where the file gives it."""

from __future__ import annotations

import contextlib
import logging
import math
import os
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import tifffile
from numpy.typing import NDArray

from cpm_core.formats.images import raster, resolution
from cpm_core.formats.images.decoded import Decoded, UnreadableError, check_size, from_samples, upright
from cpm_core.image.colors import full_scale
from cpm_core.image.gray_levels import NO_DATA

# tifffile logs a warning for everything unusual in a file; the user gets one sentence on what matters instead.
logging.getLogger("tifffile").addHandler(logging.NullHandler())

_MOST_PACKED, _ALWAYS = 5000, 2**30
"""Bytes that one byte of a packed page may stand for, and bytes that any page may hold, as of one value."""

_MAGIC = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_BY_PILLOW = frozenset({2, 3, 4, 6, 7, 32771})
"""Compressions that Pillow unpacks without a loss of depth: those of fax machines, which have one bit, and JPEG."""

_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE, _INKS, _YCBCR = 0, 1, 2, 3, 5, 6
_KNOWN_LEVELS = (_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE, _INKS)
_JPEG = 7
_PREMULTIPLIED = 1
_CYAN_TO_BLACK = 1
"""Inks of cyan, magenta, yellow and black, among sets of inks."""
_LARGEST_PART = 2**24
"""Pixels that a tile or strip may have beyond some times those of the image."""

_INCH, _CENTIMETER = 2, 3
_PER_METER = {_INCH: 1 / 0.0254, _CENTIMETER: 100.0}


def is_tiff(head: bytes) -> bool:
    """Whether the first bytes of a file are those of a TIFF."""
    return head.startswith(_MAGIC)


def first_page(path: Path) -> Decoded:
    """Read the first page of a TIFF.

    Raises
    ------
    UnreadableError
        When the page is too large or a volume. Damaged files raise any exception of the decoder.
    """
    with tifffile.TiffFile(path) as file:
        page = file.pages.first
        if page.imagedepth > 1:
            raise UnreadableError(f"{path.name} is a volume: save one plane of it as an image of its own.")
        decoded = page_of(file, page, path)
        return replace(decoded, notes=(*decoded.notes, *_page_notes(file)))


def page_of(file: tifffile.TiffFile, page: tifffile.TiffPage, path: Path) -> Decoded:
    """Gray levels of a page, upright, with the size of a pixel.

    A file of OME names pages of other files, which are opened for as long as they are read.
    """
    own = page.parent.filehandle
    closed = own.closed
    if closed:
        own.open()
    try:
        return _page_of(file, page, path, Path(own.path))
    finally:
        if closed:
            own.close()


def _page_of(file: tifffile.TiffFile, page: tifffile.TiffPage, path: Path, own: Path) -> Decoded:
    """The same, of a page of an open file."""
    check_size(path.name, int(page.imagelength), int(page.imagewidth))  # damaged ones may be tuples
    size = page.parent.filehandle.size
    if max(page.databytecounts, default=0) > size:  # memory for them would be taken first
        raise EOFError(f"{path.name} names more bytes than it has.")
    if page.nbytes > max(_ALWAYS, _MOST_PACKED * size):  # a pixel may have any number of samples
        raise EOFError(f"{path.name} names more samples than it has.")
    if math.prod(page.chunks) > _LARGEST_PART + 4 * page.imagelength * page.imagewidth * page.samplesperpixel:
        raise ValueError("a part of it is far larger than the whole")
    spacing, unit = spacing_of(file, page)
    direct = page.photometric in _KNOWN_LEVELS and page.compression not in _BY_PILLOW
    shown = None if direct else _by_pillow(page, own, path.name)
    if shown is None:
        return turned(
            page,
            replace(pixels(page, _raw(page, path.name), page.bitspersample, path.name), spacing=spacing, unit=unit),
        )
    # Pillow has turned the pixels; the size of a pixel turns with them
    turned_size = turned(page, Decoded(np.empty((0, 0)), spacing, unit, shown.notes))
    return replace(turned_size, values=shown.values, colors=shown.colors)


def _by_pillow(page: tifffile.TiffPage, path: Path, name: str) -> Decoded | None:
    """Gray levels of a page, upright; None for a kind that Pillow does not know and tifffile may."""
    try:
        with _native_silence(), PIL.Image.open(path, formats=("TIFF",)) as picture:
            picture.seek(int(page.index))
            return raster.pixels(picture)
    except PIL.UnidentifiedImageError:
        if page.photometric in _KNOWN_LEVELS or _becomes_rgb(page):
            return None
        raise _uncommon(page, name) from None


def _becomes_rgb(page: tifffile.TiffPage) -> bool:
    """Whether unpacking a page turns its colors into red, green and blue."""
    return page.photometric == _YCBCR and page.compression == _JPEG


def _raw(page: tifffile.TiffPage, name: str) -> NDArray[Any]:
    """Pixels as they are stored; UnreadableError for those of three bytes, whose order tifffile gets wrong."""
    if page.bitspersample == 24:
        raise _uncommon(page, name)
    with _native_silence():
        return np.asarray(page.asarray(maxworkers=1))


def _uncommon(page: tifffile.TiffPage, name: str) -> UnreadableError:
    """What is said of a page with colors that are not read."""
    if isinstance(page.photometric, tifffile.PHOTOMETRIC) and page.photometric not in _KNOWN_LEVELS:
        return UnreadableError(
            f"{name} is a TIFF with colors of the kind {page.photometric.name}, which are not read: save it again "
            "in gray, or in red, green and blue."
        )
    return UnreadableError(
        f"{name} is damaged or a TIFF of an uncommon kind: save it again as an uncompressed TIFF or as PNG."
    )


def pixels(page: tifffile.TiffPage, raw: NDArray[Any], bits: object, name: str) -> Decoded:
    """Gray levels of the samples of a page, which have so many bits each."""
    if raw.ndim < 2 or raw.size != page.imagelength * page.imagewidth * page.samplesperpixel:
        raise ValueError("pixels are missing")
    if page.axes == "SYX":
        raw = np.moveaxis(raw, 0, -1)
    stored = samples = raw if raw.ndim == 3 else raw[..., np.newaxis]
    notes: list[str] = []
    if samples.dtype == np.bool_:
        samples, bits = samples.astype(np.uint8) * np.uint8(255), 8
        notes.append("Black and white were read as 0 and 255.")
    if page.photometric == _PALETTE:
        table = np.asarray(page.colormap, dtype=np.float64)
        table = table if table.max() < 256.0 else table / 257.0  # old programs write eight bits in sixteen
        samples, bits = np.rint(table).astype(np.uint8).T[samples[..., 0]], 8
    white = _white(bits, samples)
    if page.photometric == _INKS:
        samples = _light_of_inks(page, samples, white, name)
    count = 1 if page.photometric in (_WHITE_IS_ZERO, _BLACK_IS_ZERO) else 3
    extra = samples[..., count:]
    has_alpha = extra.shape[-1] > 0 and bool(page.extrasamples) and int(page.extrasamples[0]) in (1, 2)
    if extra.shape[-1] > has_alpha:
        notes.append(f"Only the first {count + has_alpha} of its {samples.shape[-1]} channels were taken.")
    colors, opacity = samples[..., :count], extra[..., 0] / _white(bits, extra[..., 0]) if has_alpha else None
    if page.photometric == _WHITE_IS_ZERO:
        colors = white - colors
        notes.append("It counts from white to black and was inverted.")
    if opacity is not None and int(page.extrasamples[0]) == _PREMULTIPLIED:
        share = opacity[..., np.newaxis]
        colors = np.divide(colors, share, out=np.zeros(colors.shape), where=share > 0.0)
    decoded = from_samples(colors, opacity, tuple(notes), white)
    told = stored[..., : 1 if page.photometric == _PALETTE else count]
    return replace(decoded, values=_without_no_data(page, decoded.values, told))


def turned(page: tifffile.TiffPage, decoded: Decoded) -> Decoded:
    """What was read of a page, upright by its orientation tag."""
    return upright(decoded, _number(page, "Orientation", 1))


def lies_across(page: tifffile.TiffPage) -> bool:
    """Whether rows of a page become columns by its orientation tag."""
    return _number(page, "Orientation", 1) in range(5, 9)


def _light_of_inks(page: tifffile.TiffPage, samples: NDArray[Any], white: float, name: str) -> NDArray[Any]:
    """Red, green and blue of cyan, magenta, yellow and black, and what stands behind these."""
    if _number(page, "InkSet", _CYAN_TO_BLACK) != _CYAN_TO_BLACK or samples.shape[-1] < 4:
        raise _uncommon(page, name)
    light = (white - samples[..., :3]) * (1.0 - samples[..., 3:4] / white)
    return np.concatenate([light.astype(samples.dtype), samples[..., 4:]], axis=-1)


def _without_no_data(page: tifffile.TiffPage, gray: NDArray[Any], stored: NDArray[Any]) -> NDArray[Any]:
    """Gray levels with `NO_DATA` where all samples are the value that a geographic program says stands for no data."""
    told = page.tags.valueof("GDAL_NODATA")
    try:
        absent_value = float(told)
    except (TypeError, ValueError):
        return gray
    absent = (np.isnan(stored) if math.isnan(absent_value) else stored == absent_value).all(axis=-1)
    return np.where(absent, np.float64(NO_DATA), gray) if absent.any() else gray


def _white(bits: object, samples: NDArray[Any]) -> float:
    """Level of white, of pixels with fewer bits than their type too."""
    return 2.0**bits - 1.0 if isinstance(bits, int) and samples.dtype.kind == "u" else full_scale(samples)


def _page_notes(file: tifffile.TiffFile) -> tuple[str, ...]:
    """Note further pages, which ImageJ may keep behind a single directory."""
    stack = file.imagej_metadata or {}
    pages = max(len(file.pages), int(stack.get("images", 1)))
    return (f"Only the first of its {pages} pages was taken.",) if pages > 1 else ()


def spacing_of(file: tifffile.TiffFile, page: tifffile.TiffPage, series: int = 0) -> resolution.Spacing:
    """Pixel size on the specimen from OME or ImageJ; else from the resolution tag, when it is plausible."""
    if file.ome_metadata:
        entries = _of_ome(file, series)
        row, col = entries.get("PhysicalSizeY"), entries.get("PhysicalSizeX")
        units = {entries.get(f"PhysicalSize{axis}Unit", "µm") for axis in "XY"}
        if row and col and len(units) == 1:
            return resolution.from_sizes(float(row), float(col), units.pop())
        return resolution.UNKNOWN
    columns, rows = _density(page, "XResolution"), _density(page, "YResolution")
    if not (columns > 0 and rows > 0):
        return resolution.UNKNOWN
    stack = file.imagej_metadata
    if stack and "unit" in stack:
        return resolution.from_sizes(1 / rows, 1 / columns, str(stack["unit"]))
    factor = _PER_METER.get(_number(page, "ResolutionUnit", 1), 0.0)
    return resolution.from_density(rows * factor, columns * factor)


def depth_of(file: tifffile.TiffFile, unit: str | None, series: int = 0) -> float | None:
    """Distance of neighboring planes from OME or ImageJ, in the unit of the pixel size; None when it is not told."""
    if file.ome_metadata:
        entries = _of_ome(file, series)
        told, named = entries.get("PhysicalSizeZ"), entries.get("PhysicalSizeZUnit", "µm")
    else:
        told, named = (file.imagej_metadata or {}).get("spacing"), str((file.imagej_metadata or {}).get("unit"))
    try:
        (depth, _), its_unit = resolution.from_sizes(abs(float(told or 0.0)), 1.0, named)
    except (TypeError, ValueError):
        return None
    return None if its_unit is None or unit is None else depth * resolution.factor(its_unit, unit)


def _of_ome(file: tifffile.TiffFile, series: int) -> dict[str, str]:
    """Sizes of a pixel as OME tells them of one of its images."""
    found = re.findall(r"<Pixels\b[^>]*>", file.ome_metadata or "")
    pixels = found[series] if series < len(found) else ""
    return dict(re.findall(r"\b(PhysicalSize[XYZ](?:Unit)?)=\"([^\"]*)\"", pixels))


def _density(page: tifffile.TiffPage, name: str) -> float:
    """A resolution tag as pixels per unit; 0 when it is missing or not valid."""
    tag = page.tags.get(name)
    if tag is None or not isinstance(tag.value, tuple) or len(tag.value) != 2 or not tag.value[1]:
        return 0.0
    return float(tag.value[0]) / float(tag.value[1])


def _number(page: tifffile.TiffPage, name: str, otherwise: int) -> int:
    tag = page.tags.get(name)
    return int(tag.value) if tag is not None and isinstance(tag.value, int) else otherwise


@contextlib.contextmanager
def _native_silence() -> Iterator[None]:
    """Discard the standard error of the whole process within the block.

    libtiff prints warnings on unusual files directly to the file descriptor, and Pillow cannot turn them off.
    """
    try:
        kept = os.dup(2)
    except OSError:  # a window without a console has no standard error
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
