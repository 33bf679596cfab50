"""Analyze 7.5: volumes of older programs in two files, read by nibabel."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images import resolution
from cpm_core.formats.images.decoded import DecodedImage, decode_voxels
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.stack import Stack, find_values_of_pair
from cpm_core.parameters.formatting import quote_value

FILE_KINDS = {".hdr": "NIfTI or Analyze 7.5 volume of two files"}

_ANALYZE_HEADER_SIZE = 348
"""Size of a header, which is also its first entry [bytes]."""


def can_read(head: bytes, path: Path) -> bool:
    """Return whether a file is a header of Analyze; that of NIfTI begins alike and is tried first."""
    sizes = (int.from_bytes(head[:4], "little"), int.from_bytes(head[:4], "big"))
    return path.suffix.lower() == ".hdr" and len(head) >= _ANALYZE_HEADER_SIZE and _ANALYZE_HEADER_SIZE in sizes


def open_image_file(path: Path, _reading: Reading) -> Stack:
    """Open a volume: the axes of the file are columns, rows, planes and times.

    Raises
    ------
    UnreadableError
        When the file has more axes, or the one with its values is missing.
    """
    name = make_printable(path.name)
    find_values_of_pair(path)
    volume = _open_volume(path)
    sizes = [int(size) for size in volume.shape]
    if len(sizes) < 2 or min(sizes) < 1:
        raise ValueError("there are too few axes")
    if math.prod(sizes[4:]) > 1:
        raise UnreadableError(f"{name} has {len(sizes)} axes, {quote_value(tuple(sizes))}: save one volume of it.")
    columns, rows, planes, times = (*sizes, 1, 1)[:4]
    stored = volume.get_data_dtype()
    unit = bytes(volume.header["vox_units"]).decode("latin-1").strip("\0 ") or "mm"
    sides = [abs(float(side)) for side in (*volume.header.get_zooms()[:3], 1.0)[2::-1]]
    (deep, row, col), known = resolution.spacing_from_sizes(sides, 3 * [unit])

    def read_planes(time: int, _channel: int, first: int, end: int) -> DecodedImage:
        at = (slice(None), slice(None), slice(first, end), time)
        part: Any = np.array(_open_volume(path).dataobj[at[: len(sizes)]]).reshape(columns, rows, end - first).T
        return decode_voxels(part)

    return Stack(
        name,
        (planes, rows, columns),
        read_planes,
        stored.itemsize + (8.0 if stored.fields is None else 0.0),
        times,
        1,
        (deep, row, col),
        known,
        notes=("Its format, Analyze 7.5, does not say where it lies, nor which side is left.",),
    )


def _open_volume(path: Path) -> Any:
    """Open a volume, reading only its header; nibabel tells the variants of the format from each other."""
    import nibabel  # only here, because it takes long to import

    return nibabel.load(path)
