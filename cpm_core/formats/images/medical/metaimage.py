"""MetaImage: volumes of ITK, in one file (.mha) or with the values in a file beside the header (.mhd)."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from cpm_core.formats.common.printable import printable
from cpm_core.formats.images.choice import FIRST, Choice
from cpm_core.formats.images.decoded import Decoded, UnreadableError, from_samples
from cpm_core.formats.images.medical.content import Packing, beside, values_of
from cpm_core.formats.images.stacks.stack import Stack, as_planes, plane_of
from cpm_core.image.geometry import Geometry, from_affine

FORMAT = "MetaImage"
READS = {".mha": "MetaImage volume", ".mhd": "MetaImage volume of two files"}

_BEGINNINGS = (b"ObjectType", b"NDims", b"ObjectSubType", b"Comment")
_LONGEST_HEADER = 2**16
_TYPES = {
    "CHAR": "i1",
    "UCHAR": "u1",
    "SHORT": "i2",
    "USHORT": "u2",
    "INT": "i4",
    "UINT": "u4",
    "LONG": "i4",
    "ULONG": "u4",
    "LONG_LONG": "i8",
    "ULONG_LONG": "u8",
    "FLOAT": "f4",
    "DOUBLE": "f8",
}
_UNITS = {"mm": "mm", "um": "µm", "cm": "cm"}
_YES = ("true", "1", "yes")


def reads(head: bytes, _path: Path) -> bool:
    """Whether the first bytes of a file are those of a header of MetaImage."""
    return head.startswith(_BEGINNINGS) and b"=" in head[:40]


def read(path: Path, choice: Choice = FIRST) -> Decoded:
    """Read one plane of a volume; see `plane_of`."""
    return plane_of(stack(path, choice), choice)


def stack(path: Path, _choice: Choice = FIRST) -> Stack:
    """Open a volume; its columns are the first axis of the file, its planes the third, times a fourth."""
    name = printable(path.name)
    entries, end = _header(path)
    sizes = [int(size) for size in entries["dimsize"].split()]
    bands = int(entries.get("elementnumberofchannels", "1"))
    if not 2 <= len(sizes) <= 4 or int(entries["ndims"]) != len(sizes):
        raise UnreadableError(f"{name} has {len(sizes)} axes, but a volume has two to four: save one volume of it.")
    if min(*sizes, bands) < 1:
        raise ValueError("there are no values")
    columns, rows, planes, times = (*sizes, 1, 1)[:4]
    most_first = entries.get("binarydatabyteordermsb", entries.get("elementbyteordermsb", "False")).lower() in _YES
    named = entries["elementtype"].removeprefix("MET_").removesuffix("_ARRAY")
    kind = np.dtype(_TYPES[named]).newbyteorder(">" if most_first else "<")
    file, offset = _content(path, entries, end)
    packing: Packing = "deflate" if entries.get("compresseddata", "False").lower() in _YES else "raw"
    shape = (times, planes, rows, columns, bands)
    if packing == "raw":
        values_of(file, offset, shape, kind)  # whether they are all there
    place = _place(entries, len(sizes))
    color = bands in (3, 4) and kind.kind == "u"

    def take(time: int, channel: int, first: int, end: int) -> Decoded:
        part = values_of(file, offset, shape, kind, packing)[time, first:end]
        if not color:
            return Decoded(np.array(part[..., channel]))
        samples = np.array(part).reshape(-1, columns, bands)
        found = from_samples(samples[..., :3], samples[..., 3] if bands == 4 else None)
        return as_planes(found, (end - first, rows, columns))

    return Stack(
        name,
        (planes, rows, columns),
        take,
        float(kind.itemsize * bands),
        times,
        1 if color else bands,
        place.spacing,
        place.unit,
        place.geometry,
        notes=place.notes,
        otherwise=planes // 2,
    )


def _header(path: Path) -> tuple[dict[str, str], int]:
    """Entries by name, in lower case, and where the header ends: the entry on the place of the values is its last."""
    entries: dict[str, str] = {}
    with path.open("rb") as stream:
        while stream.tell() < _LONGEST_HEADER:
            line = stream.readline(_LONGEST_HEADER)
            name, equals, value = line.decode("latin-1").partition("=")
            if not equals:
                break
            entries[name.strip().lower()] = value.strip()
            if name.strip().lower() == "elementdatafile":
                return entries, stream.tell()
    raise ValueError("the header has no end")


def _content(path: Path, entries: dict[str, str], end: int) -> tuple[Path, int]:
    """File of the values and where they begin in it."""
    named = entries["elementdatafile"]
    if named.upper() == "LOCAL":
        return path, end
    if named.upper().startswith("LIST") or "%" in named:
        raise UnreadableError(f"{path.name} keeps its planes in files of their own: save it as one file, .mha.")
    return beside(path, named), int(entries.get("headersize", "0"))


class _Place(NamedTuple):
    """Size of a voxel, its unit, and where the volume lies."""

    spacing: tuple[float, float, float]
    unit: str | None
    geometry: Geometry | None
    notes: tuple[str, ...] = ()


def _place(entries: dict[str, str], axes: int) -> _Place:
    def numbers(*names: str) -> Any:
        found = next((entries[name] for name in names if name in entries), None)
        return None if found is None else np.array([float(part) for part in found.split()])

    sides = numbers("elementspacing", "elementsize")
    origin, matrix = numbers("offset", "position", "origin"), numbers("transformmatrix", "rotation", "orientation")
    unit = None if sides is None else _UNITS.get(entries.get("distanceunits", "mm").lower(), "mm")
    spacing = np.ones(3)
    if sides is not None:
        spacing[: min(axes, 3)] = np.abs(sides[:3])
    if not all(math.isfinite(side) and side > 0.0 for side in spacing):
        raise ValueError("a side of a voxel is not valid")
    if origin is None and matrix is None:
        return _Place(tuple(spacing[::-1].tolist()), unit, None)
    count = min(axes, 3)
    affine = np.eye(4)
    if matrix is not None:  # the direction of each axis, one after the other
        affine[:count, :count] = matrix.reshape(axes, axes)[:count, :count].T
    affine[:3, :3] *= spacing
    if origin is not None:
        affine[:count, 3] = origin[:count]
    try:
        geometry, sizes = from_affine(affine, "LPS")
    except ValueError:
        untold = ("Its matrix is not valid, so that it is not known where it lies.",)
        return _Place(tuple(spacing[::-1].tolist()), unit, None, untold)
    return _Place(sizes, unit, geometry)
