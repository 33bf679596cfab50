"""NumPy arrays: ``.npy`` files, and ``.npz`` archives of them, of gray levels or of colors."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as array_format

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images.decoded import DecodedImage, check_pixel_count, decode_bands
from cpm_core.formats.images.reading import Reading, select_series
from cpm_core.formats.images.stack import Stack, check_memory
from cpm_core.image.image import MINIMUM_SIDE
from cpm_core.numerics.types import Extent, Numbers, Texts

FILE_KINDS = {".npy": "NumPy array", ".npz": "archive of NumPy arrays"}

_ZIP_MAGIC = b"PK\x03\x04"
"""First bytes of a ZIP archive."""

_ARRAY_SUFFIX = ".npy"
"""Suffix of the arrays in an archive."""


def can_read(head: bytes, path: Path) -> bool:
    """Return whether a file begins like a NumPy array, or is an archive that holds one."""
    if head.startswith(b"\x93NUMPY"):
        return True
    if not head.startswith(_ZIP_MAGIC):
        return False
    try:
        with zipfile.ZipFile(path) as archive:
            return any(name.endswith(_ARRAY_SUFFIX) for name in archive.namelist())
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError):
        return path.suffix.lower() == ".npz"


def open_image_file(path: Path, reading: Reading) -> Stack:
    """Open an array of two or three axes, perhaps with colors along a last one; from an archive the selected array."""
    name = make_printable(path.name)
    shape, kind, names, number = _read_array_header(path, reading, name)
    member = names[number] + _ARRAY_SUFFIX if names else ""
    if kind.kind not in "buif":
        raise UnreadableError(f"{name} holds values of type {str(kind)[:80]}, but gray levels must be real numbers.")
    count = len(shape)
    color = count in (3, 4) and shape[-1] in (3, 4)
    if count - color not in (2, 3) or (count == 4 and not color):
        raise UnreadableError(
            f"{name} holds an array of shape {shape}, but an image is (rows, columns) and a volume "
            "(planes, rows, columns), with 3 or 4 channels at most: save one of it."
        )
    planes, rows, columns = (1, *shape[: count - color])[-3:]
    if planes == 1:
        check_pixel_count(name, rows, columns)

    def read_planes(_time: int, _channel: int, first: int, end: int) -> DecodedImage:
        stored = _read_array(path, member)
        whole = stored.reshape(planes, rows, columns, *shape[count - color :])
        part = np.array(whole[first:end])
        return decode_bands(part) if color else DecodedImage(part)

    each = float(kind.itemsize * (shape[-1] if color else 1))
    if member:
        check_memory(tuple(shape), kind.itemsize, name)
    return Stack(name, (planes, rows, columns), read_planes, each, series=names, series_number=number)


def _read_array_header(path: Path, reading: Reading, name: str) -> tuple[Extent, np.dtype[Any], Texts, int]:
    """Read shape and type of the selected array, and for an archive the names of all arrays and its index."""
    with path.open("rb") as stream:
        if stream.read(4) != _ZIP_MAGIC:
            stored: Numbers = np.load(path, mmap_mode="r", allow_pickle=False)
            return stored.shape, stored.dtype, (), 0
    with zipfile.ZipFile(path) as archive:
        members = [info for info in archive.infolist() if info.filename.endswith(_ARRAY_SUFFIX)]
        headers = []
        for info in members:
            with archive.open(info) as stream:
                old = array_format.read_magic(stream) == (1, 0)
                read_header = array_format.read_array_header_1_0 if old else array_format.read_array_header_2_0
                shape, _, kind = read_header(stream)
                headers.append((shape, kind))
    names = tuple(info.filename.removesuffix(_ARRAY_SUFFIX) for info in members)
    images = [at for at, (shape, kind) in enumerate(headers) if _is_image(shape, kind)]
    if reading.series is None and len(images) != 1:
        raise UnreadableError(
            f"{name} holds {len(images)} images and volumes, of {len(names)} arrays: choose one by series, "
            "a number or a name.",
            tuple(images),
        )
    at = select_series(reading, names, name, images[0] if images else 0)
    shape, kind = headers[at]
    return shape, kind, names, at


def _is_image(shape: Extent, kind: np.dtype[Any]) -> bool:
    """Return whether an array of an archive may be an image, unlike labels, sizes and the like."""
    return kind.kind in "buif" and len(shape) in (2, 3, 4) and min(shape[:2]) >= MINIMUM_SIDE


def _read_array(path: Path, member: str) -> Numbers:
    """Read an array; one in a file of its own is memory-mapped."""
    if not member:
        return np.asarray(np.load(path, mmap_mode="r", allow_pickle=False))
    with zipfile.ZipFile(path) as archive, archive.open(member) as stream:
        return np.asarray(array_format.read_array(stream, allow_pickle=False))
