"""NIfTI: volumes of the brain and of other parts of the body, read by nibabel."""

from __future__ import annotations

import gzip
import logging
import math
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.printable import printable
from cpm_core.formats.images.choice import FIRST, Choice
from cpm_core.formats.images.decoded import Decoded, UnreadableError, from_samples
from cpm_core.formats.images.stacks.stack import Stack, as_planes, check_content, plane_of
from cpm_core.image.geometry import Geometry, from_affine
from cpm_core.parameters.quotation import shown

FORMAT = "NIfTI"
READS = {".nii": "NIfTI volume", ".nii.gz": "the same, compressed", ".hdr": "NIfTI volume of two files"}

_GZIP = b"\x1f\x8b"
_FIRST_VERSION, _SECOND_VERSION = (b"n+1\0", b"ni1\0"), (b"n+2\0\r\n\x1a\n", b"ni2\0\r\n\x1a\n")
_LENGTHS = (b"\x5c\1\0\0", b"\0\0\1\x5c", b"\x1c\2\0\0", b"\0\0\2\x1c")
"""First bytes of a header, which are its length, of both versions in both orders of bytes."""

# nibabel prints a line for everything unusual in a header; the user gets one sentence on what matters instead.
logging.getLogger("nibabel.global").setLevel(logging.CRITICAL + 1)

_AT_ONCE = 2**20
"""Bytes that are unpacked at once."""

_UNITS = {"mm": "mm", "micron": "µm", "meter": "m"}


def reads(head: bytes, path: Path) -> bool:
    """Whether the first bytes of a file, unpacked if they are packed, are those of a NIfTI volume.

    In a file that is named as one, those that packed files and Analyze volumes share with it are enough.
    """
    named = path.name.lower().endswith((".nii", ".nii.gz"))
    return _version(head, path) is not None or (named and head.startswith((_GZIP, *_LENGTHS)))


def read(path: Path, choice: Choice = FIRST) -> Decoded:
    """Read one plane of a volume; see `plane_of`."""
    return plane_of(stack(path, choice), choice)


def stack(path: Path, _choice: Choice = FIRST) -> Stack:
    """Open a volume; its planes are the third axis of the file, its rows the second.

    Raises
    ------
    UnreadableError
        When the file has more axes than planes, rows, columns, times and channels.
    """
    name = printable(path.name)
    with _opened(path) as volume:
        sizes = [int(size) for size in volume.shape]
        if len(sizes) < 2 or min(sizes) < 1:
            raise ValueError("there are too few axes")
        if math.prod(sizes[5:]) > 1:
            raise UnreadableError(f"{name} has {len(sizes)} axes, {shown(tuple(sizes))}: save one volume of it.")
        columns, rows, planes, times, channels = (*sizes, 1, 1, 1)[:5]
        stored = volume.get_data_dtype()
        packed = _is_packed(path)
        image = Path(volume.file_map["image"].filename or path)
        check_content(image, math.prod(sizes) * stored.itemsize, packed or image.suffix == ".gz")
        unit, notes = _unit(volume.header)
        spacing, geometry, doubts = _place(volume)
    scaled = 8.0 if stored.fields is None else 0.0

    def take(time: int, channel: int, first: int, end: int) -> Decoded:
        at = (slice(None), slice(None), slice(first, end), time, channel)
        part = _part(path, at[: len(sizes)], packed).reshape(columns, rows, end - first).T
        if part.dtype.fields is None:
            return Decoded(part)
        samples = np.stack([part[band] for band in part.dtype.names], axis=-1).reshape(-1, columns, len(part.dtype))
        colors, alpha = samples[..., :3], samples[..., 3] if samples.shape[-1] == 4 else None
        return as_planes(from_samples(colors, alpha), (end - first, rows, columns))

    return Stack(
        name,
        (planes, rows, columns),
        take,
        stored.itemsize + scaled,
        times,
        channels,
        spacing,
        unit,
        geometry,
        notes=(*notes, *doubts),
        otherwise=planes // 2,
    )


def _version(head: bytes, path: Path) -> int | None:
    """Version of the format by the first bytes of a file; None for other files."""
    if head.startswith(_GZIP):
        try:
            with gzip.open(path) as stream:
                head = stream.read(348)
        except (OSError, EOFError, ValueError, zlib.error):
            return None
    if head.startswith(_FIRST_VERSION, 344):
        return 1
    return 2 if head.startswith(_SECOND_VERSION, 4) else None


def _is_packed(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(2) == _GZIP


def _part(path: Path, at: tuple[slice | int, ...], packed: bool) -> Any:
    """A part of the values; BadGzipFile or EOFError when the sum at the end of a packed file is wrong or missing."""
    with _opened(path) as volume:
        part = np.asanyarray(volume.dataobj[at])
    if packed:
        with gzip.open(path) as stream:
            while stream.read(_AT_ONCE):
                pass
    return part


@contextmanager
def _opened(path: Path) -> Iterator[Any]:
    """The volume, of which nothing but the header has been read; its content decides on its kind, not its name."""
    import nibabel  # only here, because it takes long to import

    with path.open("rb") as raw:
        stream: Any = gzip.GzipFile(fileobj=raw) if _is_packed(path) else raw
        head = stream.read(352)
        stream.seek(0)
        version = _version(head, path)
        if version is None:
            raise ValueError("it has no mark of the format")
        pair = head[345:346] == b"i" if version == 1 else head[5:6] == b"i"
        kind = {(1, False): "Nifti1Image", (1, True): "Nifti1Pair", (2, False): "Nifti2Image", (2, True): "Nifti2Pair"}
        reader = getattr(nibabel, kind[version, pair])
        if pair:
            yield reader.from_filename(path)
        else:
            holder = nibabel.fileholders.FileHolder(fileobj=stream)
            yield reader.from_file_map({"header": holder, "image": holder}, mmap=False, keep_file_open=True)


def _unit(header: Any) -> tuple[str, tuple[str, ...]]:
    """Unit of length; millimeters where none is told, as all programs take it."""
    told = header.get_xyzt_units()[0]
    if told in _UNITS:
        return _UNITS[told], ()
    return "mm", ("It names no unit of length; millimeters were taken.",)


def _place(volume: Any) -> tuple[tuple[float, float, float], Geometry | None, tuple[str, ...]]:
    """Size of a voxel, where the volume lies, and a note when it does not say."""
    try:
        geometry, spacing = from_affine(volume.affine, "RAS")
        return spacing, geometry, ()
    except ValueError:
        sides = [abs(float(side)) for side in (*volume.header.get_zooms()[:3], 1.0, 1.0)[2::-1]]
        sound = all(math.isfinite(side) and side > 0.0 for side in sides)
        plane, row, col = sides if sound else (1.0, 1.0, 1.0)
        return (plane, row, col), None, ("Its matrix is not valid, so that it is not known where it lies.",)
