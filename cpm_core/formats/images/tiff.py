"""TIFF: microscopy and scientific images of any depth, with the size of a pixel where the file gives it."""

from __future__ import annotations

import contextlib
import logging
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import PIL.Image
import tifffile
from numpy.typing import NDArray

from cpm_core.formats.images import raster, resolution
from cpm_core.formats.images.decoded import Decoded, UnreadableError, check_size, full_scale, to_gray, upright

READS = {".tif": "TIFF image, first page", ".tiff": "TIFF image, first page"}

# tifffile logs a warning for everything unusual in a file; the user gets one sentence on what matters instead.
logging.getLogger("tifffile").addHandler(logging.NullHandler())

_MAGIC = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_PLAIN_COMPRESSIONS = (1, 8, 32773, 32946)  # none, deflate, PackBits: tifffile unpacks them itself, Pillow all others
_WHITE_IS_ZERO, _BLACK_IS_ZERO, _RGB, _PALETTE = 0, 1, 2, 3
_INCH, _CENTIMETER = 2, 3
_PER_METER = {_INCH: 1 / 0.0254, _CENTIMETER: 100.0}


def reads(head: bytes, _path: Path) -> bool:
    """Whether the first bytes of a file are those of a TIFF."""
    return head.startswith(_MAGIC)


def read(path: Path) -> Decoded:
    """Read the first page of a TIFF.

    Raises
    ------
    UnreadableError
        When the page is too large or a volume. Damaged files raise any exception of the decoder.
    """
    with tifffile.TiffFile(path) as file:
        page = file.pages.first
        check_size(path.name, page.imagelength, page.imagewidth)
        if page.imagedepth > 1:
            raise UnreadableError(f"{path.name} is a volume: save one plane of it as an image of its own.")
        if page.compression in _PLAIN_COMPRESSIONS and page.photometric in (0, 1, 2, 3):
            decoded = _pixels(page)
        else:
            with _native_silence(), _open_packed(path) as picture:
                decoded = raster.pixels(picture)
        notes = (*decoded.notes, *_page_notes(file))
        spacing, unit = _spacing(file, page)
        return upright(Decoded(decoded.values, spacing, unit, notes), _number(page, "Orientation", 1))


def _open_packed(path: Path) -> PIL.Image.Image:
    try:
        return PIL.Image.open(path, formats=("TIFF",))
    except PIL.UnidentifiedImageError:
        raise UnreadableError(
            f"{path.name} is damaged or a TIFF of an uncommon kind: save it again as an uncompressed TIFF or as PNG."
        ) from None


def _pixels(page: tifffile.TiffPage) -> Decoded:
    """Gray levels of a page that tifffile unpacks by itself."""
    raw: NDArray[Any] = np.asarray(page.asarray(maxworkers=1))
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
        samples = np.rint(table.T[samples[..., 0]])
        count = 3
    else:
        count = 3 if page.photometric == _RGB else 1
    if page.photometric == _WHITE_IS_ZERO:
        samples = full_scale(samples) - samples
        notes.append("It counts from white to black and was inverted.")
    extra = samples[..., count:]
    has_alpha = extra.shape[-1] > 0 and bool(page.extrasamples) and int(page.extrasamples[0]) in (1, 2)
    if extra.shape[-1] > has_alpha:
        notes.append(f"Only the first {count + has_alpha} of its {samples.shape[-1]} channels were taken.")
    gray, color_notes = to_gray(samples[..., :count], extra[..., 0] if has_alpha else None)
    return Decoded(gray, notes=(*notes, *color_notes))


def _page_notes(file: tifffile.TiffFile) -> tuple[str, ...]:
    """Note further pages, which ImageJ may keep behind a single directory."""
    stack = file.imagej_metadata or {}
    pages = max(len(file.pages), int(stack.get("images", 1)))
    return (f"Only the first of its {pages} pages was taken.",) if pages > 1 else ()


def _spacing(file: tifffile.TiffFile, page: tifffile.TiffPage) -> resolution.Spacing:
    """Pixel size on the specimen from OME or ImageJ; else from the resolution tag, when it is plausible."""
    if file.ome_metadata:
        found = re.search(r"<Pixels\b[^>]*>", file.ome_metadata)
        entries = dict(re.findall(r"\b(PhysicalSize[XY](?:Unit)?)=\"([^\"]*)\"", found.group() if found else ""))
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
