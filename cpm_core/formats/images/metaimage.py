"""MetaImage: volumes of ITK, in one file (.mha) or with the values in a file next to the header (.mhd)."""

from __future__ import annotations

import math
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import printable
from cpm_core.formats.images.decoded import Decoded, from_bands
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.resolution import known_unit
from cpm_core.formats.images.stack import Position, Stack, check_content, check_memory, file_beside, position_of
from cpm_core.numerics.types import Numbers

READS = {".mha": "MetaImage volume", ".mhd": "MetaImage volume of two files"}

_BEGINNINGS = (b"ObjectType", b"NDims", b"ObjectSubType", b"Comment")
_LONGEST_HEADER = 2**16
_SIZES = {"CHAR": 1, "SHORT": 2, "INT": 4, "LONG": 4, "LONG_LONG": 8, "FLOAT": 4, "DOUBLE": 8}


def reads(head: bytes, _path: Path) -> bool:
    """Whether the first bytes of a file are those of a header of MetaImage."""
    return head.startswith(_BEGINNINGS) and b"=" in head[:40]


def stack(path: Path, _reading: Reading) -> Stack:
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
    msb_first = _is_true(entries.get("binarydatabyteordermsb", entries.get("elementbyteordermsb", "")))
    named = entries["elementtype"].removeprefix("MET_").removesuffix("_ARRAY")
    letter = "f" if named in ("FLOAT", "DOUBLE") else "u" if named.startswith("U") else "i"
    kind = np.dtype(f"{'>' if msb_first else '<'}{letter}{_SIZES[named.removeprefix('U')]}")
    packed = _is_true(entries.get("compresseddata", ""))
    file, begin = path, end
    if entries["elementdatafile"].upper() != "LOCAL":
        file, begin = file_beside(path, entries["elementdatafile"]), int(entries.get("headersize", "0"))
    shape = (times, planes, rows, columns, bands)
    needed = math.prod(shape) * kind.itemsize
    check_content(file, needed + (0 if packed else max(begin, 0)), packed)
    spacing, unit, geometry, notes = _position(entries, len(sizes))
    color = bands in (3, 4) and kind.kind == "u"

    def values() -> Numbers:
        if not packed:
            return np.memmap(file, kind, "r", begin if begin >= 0 else file.stat().st_size - needed, shape)
        check_memory(shape, kind.itemsize, name)
        unpacker = zlib.decompressobj(zlib.MAX_WBITS | 32)  # of zlib or of gzip
        content = unpacker.decompress(file.read_bytes()[max(begin, 0) :], needed + 1)
        if len(content) != needed or not unpacker.eof:  # at whose end the checksum shows whether they are sound
            raise EOFError(f"{name} names another number of bytes than it has.")
        return np.frombuffer(content, kind).reshape(shape)

    def take(time: int, channel: int, first: int, end: int) -> Decoded:
        part = values()[time, first:end]
        return from_bands(np.array(part)) if color else Decoded(np.array(part[..., channel]))

    return Stack(
        name,
        (planes, rows, columns),
        take,
        float(kind.itemsize * bands),
        times,
        1 if color else bands,
        spacing,
        unit,
        geometry,
        notes=notes,
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


def _is_true(text: str) -> bool:
    return text.lower() in ("true", "1", "yes")


def _position(entries: dict[str, str], axes: int) -> Position:
    def numbers(*names: str) -> Any:
        found = next((entries[name] for name in names if name in entries), None)
        return None if found is None else np.array(found.split(), float)

    sides = numbers("elementspacing", "elementsize")
    origin, matrix = numbers("offset", "position", "origin"), numbers("transformmatrix", "rotation", "orientation")
    unit = None if sides is None else known_unit(entries.get("distanceunits", "mm")) or "mm"
    count = min(axes, 3)
    spacing = np.ones(3)
    if sides is not None:
        spacing[:count] = np.abs(sides[:3])
    if not all(math.isfinite(side) and side > 0.0 for side in spacing):
        raise ValueError("a side of a voxel is not valid")
    col, row, plane = spacing.tolist()
    if origin is None and matrix is None:
        return (plane, row, col), unit, None, ()
    affine = np.eye(4)
    if matrix is not None:  # the direction of each axis, one after the other
        affine[:count, :count] = matrix.reshape(axes, axes)[:count, :count].T
    affine[:3, :3] *= spacing
    if origin is not None:
        affine[:count, 3] = origin[:count]
    found, _, geometry, notes = position_of(affine, "LPS", (plane, row, col), "mm")
    return found, unit, geometry, notes
