"""MetaImage: volumes of ITK, in one file (.mha) or with the values in a file next to the header (.mhd)."""

from __future__ import annotations

import math
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import printable
from cpm_core.formats.images.nrrd import stack_of
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.stack import Stack, check_memory, file_beside
from cpm_core.numerics.types import Entries, Numbers

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
    entries, begin = _header(path)
    sizes = [int(size) for size in entries["dimsize"].split()]
    if not 2 <= len(sizes) <= 4 or int(entries["ndims"]) != len(sizes):
        raise UnreadableError(f"{name} has {len(sizes)} axes, but a volume has two to four: save one volume of it.")
    bands = int(entries.get("elementnumberofchannels", "1"))
    shape = (bands, *(*sizes, 1, 1)[:4])
    msb_first = _is_true(entries.get("binarydatabyteordermsb", entries.get("elementbyteordermsb", "")))
    named = entries["elementtype"].removeprefix("MET_").removesuffix("_ARRAY")
    letter = "f" if named in ("FLOAT", "DOUBLE") else "u" if named.startswith("U") else "i"
    kind = np.dtype(f"{'>' if msb_first else '<'}{letter}{_SIZES[named.removeprefix('U')]}")
    packed = _is_true(entries.get("compresseddata", ""))
    file = path
    if entries["elementdatafile"].upper() != "LOCAL":
        file, begin = file_beside(path, entries["elementdatafile"]), int(entries.get("headersize", "0"))

    def values() -> Numbers:
        if packed:
            check_memory(shape, kind.itemsize, name)
            content = zlib.decompress(file.read_bytes()[max(begin, 0) :], zlib.MAX_WBITS | 32)  # of zlib or of gzip
            return np.ndarray(shape, kind, content, order="F")
        size = math.prod(shape) * kind.itemsize
        return np.memmap(file, kind, "r", begin if begin >= 0 else file.stat().st_size - size, shape, "F")

    color = bands in (3, 4) and kind.kind == "u"
    kinds = ["rgb-color" if color else "vector", *3 * ["domain"], "time"]
    return stack_of(name, {"sizes": shape, "kinds": kinds, **_place(entries, len(sizes))}, kind.itemsize, values)


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


def _place(entries: dict[str, str], axes: int) -> Entries:
    """The entries of NRRD on the sizes of voxels and on where they lie."""

    def numbers(*names: str) -> Any:
        found = next((entries[name] for name in names if name in entries), None)
        return None if found is None else np.array(found.split(), float)

    sides = numbers("elementspacing", "elementsize")
    origin, matrix = numbers("offset", "position", "origin"), numbers("transformmatrix", "rotation", "orientation")
    count = min(axes, 3)
    spacing, along, first = np.ones(3), np.eye(3), np.zeros(3)
    if sides is not None:
        spacing[:count] = np.abs(sides[:3])
    if matrix is not None:  # the direction of each axis, one after the other
        along[:count, :count] = matrix.reshape(axes, axes)[:count, :count]
    if origin is not None:
        first[:count] = origin[:count]
    place: Entries = {"space directions": [None, *(along * spacing[:, None]), None]}
    if sides is not None:
        place["space units"] = [entries.get("distanceunits", "mm"), "mm"]
    if origin is not None or matrix is not None:
        place |= {"space": "LPS", "space origin": first}
    return place
