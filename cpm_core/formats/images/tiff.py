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

from cpm_core.formats.images import packing, raster, resolution
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

_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE = 0, 1, 2, 3
_KNOWN_LEVELS = (_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE)
_PREMULTIPLIED = 1
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
    """Gray levels of a page, upright, with the size of a pixel."""
    check_size(path.name, int(page.imagelength), int(page.imagewidth))  # damaged ones may be tuples
    if max(page.databytecounts, default=0) > file.filehandle.size:  # memory for them would be taken first
        raise EOFError(f"{path.name} names more bytes than it has.")
    if page.nbytes > max(_ALWAYS, _MOST_PACKED * file.filehandle.size):  # a pixel may have any number of samples
        raise EOFError(f"{path.name} names more samples than it has.")
    if math.prod(page.chunks) > _LARGEST_PART + 4 * page.imagelength * page.imagewidth * page.samplesperpixel:
        raise ValueError("a part of it is far larger than the whole")
    spacing, unit = spacing_of(file, page)
    turn = _number(page, "Orientation", 1)
    direct = page.photometric in _KNOWN_LEVELS and page.compression not in _BY_PILLOW
    shown = None if direct else _by_pillow(page, path)
    if shown is None:
        return upright(replace(_pixels(page, path.name), spacing=spacing, unit=unit), turn)
    # Pillow has turned the pixels; the size of a pixel turns with them
    turned = upright(Decoded(np.empty((0, 0)), spacing, unit, shown.notes), turn)
    return replace(turned, values=shown.values, colors=shown.colors)


def _by_pillow(page: tifffile.TiffPage, path: Path) -> Decoded | None:
    """Gray levels of a page, upright; None for a kind that Pillow does not know and tifffile may."""
    try:
        with _native_silence(), PIL.Image.open(path, formats=("TIFF",)) as picture:
            picture.seek(int(page.index))
            return raster.pixels(picture)
    except PIL.UnidentifiedImageError:
        if page.photometric in _KNOWN_LEVELS:
            return None
        raise UnreadableError(
            f"{path.name} is damaged or a TIFF of an uncommon kind: save it again as an uncompressed TIFF or as PNG."
        ) from None


def _raw(page: tifffile.TiffPage, name: str) -> NDArray[Any]:
    """Pixels as they are stored; UnreadableError when a package that unpacks them is not installed."""
    with _native_silence():
        if packing.needs_unpacking(page):
            return packing.unpacked(page)
    try:
        return np.asarray(page.asarray(maxworkers=1))
    except (ValueError, NotImplementedError) as error:
        if "imagecodecs" not in str(error):
            raise
        method = page.compression.name if isinstance(page.compression, tifffile.COMPRESSION) else page.compression
        raise UnreadableError(
            f"{name} is a TIFF with pixels of {page.bitspersample} bits packed by method {method}, which needs the "
            'package imagecodecs: install it (pip install "cpm-particles[images]"), or save the image again as an '
            "uncompressed TIFF."
        ) from None


def _pixels(page: tifffile.TiffPage, name: str) -> Decoded:
    """Gray levels of a page."""
    raw = _raw(page, name)
    if raw.ndim < 2 or raw.size != page.imagelength * page.imagewidth * page.samplesperpixel:
        raise ValueError("pixels are missing")
    if page.axes == "SYX":
        raw = np.moveaxis(raw, 0, -1)
    samples = raw if raw.ndim == 3 else raw[..., np.newaxis]
    notes: list[str] = []
    if samples.dtype == np.bool_:
        samples = samples.astype(np.uint8) * np.uint8(255)
        notes.append("Black and white were read as 0 and 255.")
    if page.photometric == _PALETTE:
        table = np.asarray(page.colormap, dtype=np.float64) / 257.0
        samples = np.rint(table).astype(np.uint8).T[samples[..., 0]]
        count = 3
    else:
        count = 3 if page.photometric == _RGB else 1
    if page.photometric == _WHITE_IS_ZERO:
        samples = _white(page, samples) - samples
        notes.append("It counts from white to black and was inverted.")
    extra = samples[..., count:]
    has_alpha = extra.shape[-1] > 0 and bool(page.extrasamples) and int(page.extrasamples[0]) in (1, 2)
    if extra.shape[-1] > has_alpha:
        notes.append(f"Only the first {count + has_alpha} of its {samples.shape[-1]} channels were taken.")
    alpha = extra[..., 0] if has_alpha else None
    colors, white = samples[..., :count], full_scale(samples)
    if alpha is not None and int(page.extrasamples[0]) == _PREMULTIPLIED:
        opacity = alpha[..., np.newaxis] / full_scale(alpha)
        colors = np.divide(colors, opacity, out=np.zeros(colors.shape), where=opacity > 0.0)
    decoded = from_samples(colors, alpha, tuple(notes), white)
    if count == 1:
        values = _without_no_data(page, decoded.values, raw[..., 0] if raw.ndim == 3 else raw)
        return replace(decoded, values=values)
    return decoded


def _without_no_data(page: tifffile.TiffPage, gray: NDArray[Any], stored: NDArray[Any]) -> NDArray[Any]:
    """Gray levels with `NO_DATA` where a pixel has the value that a geographic program says stands for no data."""
    try:
        absent = stored == float(page.tags.valueof("GDAL_NODATA", "nan"))
    except (TypeError, ValueError):
        return gray
    return np.where(absent, np.float64(NO_DATA), gray) if absent.any() and not absent.all() else gray


def _white(page: tifffile.TiffPage, samples: NDArray[Any]) -> float:
    """Level of white, of pixels with fewer bits than their type too."""
    return 2.0**page.bitspersample - 1.0 if samples.dtype.kind == "u" else full_scale(samples)


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
