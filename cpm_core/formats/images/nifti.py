"""NIfTI and Analyze 7.5: volumes of the brain and other parts of the body, read by nibabel."""

from __future__ import annotations

import gzip
import itertools
import logging
import math
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images.decoded import DecodedImage, decode_voxels
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.resolution import find_unit, spacing_from_sizes
from cpm_core.formats.images.stack import Stack, VolumePosition, find_values_of_pair, position_from_affine
from cpm_core.image.geometry import Geometry, Triple, freeze_matrix
from cpm_core.numerics.types import Array, Texts
from cpm_core.parameters.formatting import quote_value

FILE_KINDS = {
    ".nii": "NIfTI volume",
    ".nii.gz": "the same, compressed",
    ".hdr": "NIfTI or Analyze 7.5 volume of two files",
}

_GZIP_MAGIC = b"\x1f\x8b"
"""First bytes of a gzip file."""

_READER_CLASSES = {
    (344, b"n+1\0"): "Nifti1Image",
    (344, b"ni1\0"): "Nifti1Pair",
    (4, b"n+2\0\r\n\x1a\n"): "Nifti2Image",
    (4, b"ni2\0\r\n\x1a\n"): "Nifti2Pair",
}
"""Offset and mark of a header -> class of nibabel that reads such a file; a pair keeps its values in another file."""

_ANALYZE_HEADER_SIZE = 348
"""Size of a header, which is also its first entry, in Analyze the only mark [bytes]."""

# nibabel prints a line for everything unusual in a header; the user gets one sentence on what matters instead.
logging.getLogger("nibabel.global").setLevel(logging.CRITICAL + 1)

_SAME_PLACE = 0.001
"""Distance up to which sform and qform are the same but for rounding [smallest side of a voxel]."""

_GZIP_BLOCK = 2**20
"""Size of the blocks in which a file is unpacked [bytes]."""


def can_read(head: bytes, path: Path) -> bool:
    """Return whether a file, unpacked if it is compressed, begins like a volume, or is a header of Analyze."""
    if path.suffix.lower() == ".hdr" and _ANALYZE_HEADER_SIZE in (
        int.from_bytes(head[:4], "little"),
        int.from_bytes(head[:4], "big"),
    ):
        return len(head) >= _ANALYZE_HEADER_SIZE
    if not head.startswith(_GZIP_MAGIC):
        return _find_reader_class(head) is not None
    try:
        with gzip.open(path) as stream:
            return _find_reader_class(stream.read(352)) is not None
    except (OSError, EOFError, ValueError, zlib.error):
        return path.name.lower().endswith(".nii.gz")


def open_image_file(path: Path, _reading: Reading) -> Stack:
    """Open a volume: the first axes of the file are columns, rows and planes.

    Raises
    ------
    UnreadableError
        When the file has more axes than planes, rows, columns, times and channels.
    """
    name = make_printable(path.name)
    with _open_volume(path) as volume:
        sizes = [int(size) for size in volume.shape]
        if len(sizes) < 2 or min(sizes) < 1:
            raise ValueError("there are too few axes")
        if math.prod(sizes[5:]) > 1:
            raise UnreadableError(f"{name} has {len(sizes)} axes, {quote_value(tuple(sizes))}: save one volume of it.")
        columns, rows, planes, times, channels = (*sizes, 1, 1, 1)[:5]
        stored = volume.get_data_dtype()
        spacing, unit, geometry, notes = _read_position(volume)
        low, high = (float(volume.header[name]) for name in ("cal_min", "cal_max"))

    def read_planes(time: int, channel: int, first: int, end: int) -> DecodedImage:
        at = (slice(None), slice(None), slice(first, end), time, channel)
        with _open_volume(path) as volume:
            part = np.asanyarray(volume.dataobj[at[: len(sizes)]]).reshape(columns, rows, end - first).T
            stream = volume.file_map["image"].fileobj
            while isinstance(stream, gzip.GzipFile) and stream.read(
                _GZIP_BLOCK
            ):  # to the end, where the checksum is verified
                pass
        return replace(decode_voxels(part), window=(low, high) if low < high < math.inf else None)

    return Stack(
        name,
        (planes, rows, columns),
        read_planes,
        stored.itemsize + (8.0 if stored.fields is None else 0.0),
        times,
        channels,
        spacing,
        unit,
        geometry,
        notes=notes,
    )


def _read_position(volume: Any) -> VolumePosition:
    """Read voxel size, unit and position of a volume; Analyze states no position."""
    header = volume.header
    sides = [abs(float(side)) for side in (*header.get_zooms()[:3], 1.0, 1.0)[2::-1]]
    if "vox_units" in header:
        own = bytes(header["vox_units"]).decode("latin-1").strip("\0 ") or "mm"
        (deep, row, col), known = spacing_from_sizes(sides, 3 * [own])
        note = "Its format, Analyze 7.5, does not say where it lies, nor which side is left."
        return (deep, row, col), known, None, (note,)
    unit = find_unit(header.get_xyzt_units()[0])
    spacing, _, geometry, notes = position_from_affine(volume.affine, "RAS", sides, "mm")
    if geometry is not None:
        geometry, more = _add_qform(geometry, volume, spacing, unit or "mm")
        notes += more
    if unit is None:
        notes = ("It names no unit of length; millimeters were taken.", *notes)
    return spacing, unit or "mm", geometry, notes


def _add_qform(geometry: Geometry, volume: Any, spacing: Triple, unit: str) -> tuple[Geometry, Texts]:
    """Add to a position by the sform the qform where it differs, and the codes of both."""
    codes = int(volume.header["sform_code"]), int(volume.header["qform_code"])
    geometry = replace(geometry, codes=codes)
    if min(codes) <= 0:
        return geometry, ()
    try:
        qform = volume.header.get_qform()[:, [2, 1, 0, 3]]
    except ValueError:
        return replace(geometry, codes=(codes[0], 0)), ("Its qform is not valid and was left out.",)
    sform = geometry.affine(spacing)
    apart = measure_displacement(qform - sform, (*volume.shape, 1)[2::-1])
    if apart <= _SAME_PLACE * min(spacing):
        return geometry, ()
    to_qform = freeze_matrix(qform @ np.linalg.inv(sform))
    said = f"Its sform and its qform lie up to {apart:.3g} {unit} apart: the sform was taken."
    return replace(geometry, to_qform=to_qform), (f"{said} Labels keep both as NIfTI, in other files only the sform.",)


def measure_displacement(difference: Array, shape: Sequence[int]) -> float:
    """Measure how far two matrices with a difference, shape (4, 4), place the voxels of a volume apart at most."""
    corners = np.array([(*corner, 1.0) for corner in itertools.product(*((0.0, side - 1.0) for side in shape))])
    return float(np.linalg.norm(corners @ difference[:3].T, axis=1).max())


def _find_reader_class(head: bytes) -> str | None:
    """Find the class of nibabel by the first bytes of a file; None for other files."""
    return next((kind for (place, mark), kind in _READER_CLASSES.items() if head.startswith(mark, place)), None)


@contextmanager
def _open_volume(path: Path) -> Iterator[Any]:
    """Open a volume, reading only its header; the content decides its kind, not the name."""
    import nibabel  # only here, because it takes long to import

    with path.open("rb") as raw:
        stream: Any = gzip.GzipFile(fileobj=raw) if raw.read(2) == _GZIP_MAGIC else raw
        raw.seek(0)
        kind = _find_reader_class(stream.read(352))
        stream.seek(0)
        if kind is None or kind.endswith("Pair"):
            find_values_of_pair(path)
            yield nibabel.load(path) if kind is None else getattr(nibabel, kind).from_filename(path)
            return
        reader = getattr(nibabel, kind)
        holder = nibabel.fileholders.FileHolder(fileobj=stream)
        yield reader.from_file_map({"header": holder, "image": holder}, mmap=False, keep_file_open=True)
