"""MetaImage: volumes of ITK, in one file (.mha) or with the values in a file next to the header (.mhd)."""

from __future__ import annotations

import math
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from cpm_core.formats.common.content import UnreadableError
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.images.nrrd import build_stack
from cpm_core.formats.images.reading import Reading
from cpm_core.formats.images.stack import Stack, check_memory, decode_header_line, find_data_file
from cpm_core.numerics.types import JsonDict, Numbers

FILE_KINDS = {".mha": "MetaImage volume", ".mhd": "MetaImage volume of two files"}

_HEADER_BEGINNINGS = (b"ObjectType", b"NDims", b"ObjectSubType", b"Comment")
"""Entries that a header may begin with."""

_MAX_HEADER_SIZE = 2**16
"""Largest size of a header [bytes]."""

_ELEMENT_SIZES = {"CHAR": 1, "SHORT": 2, "INT": 4, "LONG": 4, "LONG_LONG": 8, "FLOAT": 4, "DOUBLE": 8}
"""Type of an element, without its sign -> its size [bytes]."""


def can_read(head: bytes, _path: Path) -> bool:
    """Return whether a file begins like a header of MetaImage."""
    return head.startswith(_HEADER_BEGINNINGS) and b"=" in head[:40]


def open_image_file(path: Path, _reading: Reading) -> Stack:
    """Open a volume: the axes of the file are columns, rows, planes and times."""
    name = make_printable(path.name)
    entries, begin = _read_metaimage_header(path)
    sizes = [int(size) for size in entries["dimsize"].split()]
    if not 2 <= len(sizes) <= 4 or int(entries["ndims"]) != len(sizes):
        raise UnreadableError(f"{name} has {len(sizes)} axes, but a volume has two to four: save one volume of it.")
    bands = int(entries.get("elementnumberofchannels", "1"))
    shape = (bands, *(*sizes, 1, 1)[:4])
    msb_first = _is_true(entries.get("binarydatabyteordermsb", entries.get("elementbyteordermsb", "")))
    named = entries["elementtype"].removeprefix("MET_").removesuffix("_ARRAY")
    letter = "f" if named in ("FLOAT", "DOUBLE") else "u" if named.startswith("U") else "i"
    kind = np.dtype(f"{'>' if msb_first else '<'}{letter}{_ELEMENT_SIZES[named.removeprefix('U')]}")
    packed = _is_true(entries.get("compresseddata", ""))
    as_text = not _is_true(entries.get("binarydata", "True"))
    file = path
    if entries["elementdatafile"].upper() != "LOCAL":
        file, begin = find_data_file(path, entries["elementdatafile"]), int(entries.get("headersize", "0"))

    def read_values() -> Numbers:
        if as_text:
            check_memory(shape, kind.itemsize, name)
            with file.open("rb") as stream:
                stream.seek(max(begin, 0))
                return np.array(stream.read().split(), kind).reshape(shape, order="F")
        if packed:
            check_memory(shape, kind.itemsize, name)
            content = zlib.decompress(file.read_bytes()[max(begin, 0) :], zlib.MAX_WBITS | 32)  # zlib or gzip
            return np.ndarray(shape, kind, content, order="F")
        size = math.prod(shape) * kind.itemsize
        return np.memmap(file, kind, "r", begin if begin >= 0 else file.stat().st_size - size, shape, "F")

    color = bands in (3, 4) and kind.kind == "u"
    kinds = ["rgb-color" if color else "vector", *3 * ["domain"], "time"]
    return build_stack(
        name, {"sizes": shape, "kinds": kinds, **_convert_position(entries, len(sizes))}, kind.itemsize, read_values
    )


def _read_metaimage_header(path: Path) -> tuple[dict[str, str], int]:
    """Read the entries by name, in lower case, and the offset of their end; the location of the values is the last."""
    entries: dict[str, str] = {}
    with path.open("rb") as stream:
        while stream.tell() < _MAX_HEADER_SIZE:
            line = stream.readline(_MAX_HEADER_SIZE)
            name, equals, value = decode_header_line(line).partition("=")
            if not equals:
                break
            entries[name.strip().lower()] = value.strip()
            if name.strip().lower() == "elementdatafile":
                return entries, stream.tell()
    raise ValueError("the header has no end")


def _is_true(text: str) -> bool:
    """Return whether an entry is true."""
    return text.lower() in ("true", "1", "yes")


def _convert_position(entries: dict[str, str], axes: int) -> JsonDict:
    """Convert the entries on voxel size and position to those of NRRD."""

    def parse_numbers(*names: str) -> Any:
        found = next((entries[name] for name in names if name in entries), None)
        return None if found is None else np.array(found.split(), float)

    sides = parse_numbers("elementspacing", "elementsize")
    origin = parse_numbers("offset", "position", "origin")
    matrix = parse_numbers("transformmatrix", "rotation", "orientation")
    count = min(axes, 3)
    spacing, along, first = np.ones(3), np.eye(3), np.zeros(3)
    if sides is not None:
        spacing[:count] = np.abs(sides[:3])
    if matrix is not None:  # the direction of each axis, one after the other
        along[:count, :count] = matrix.reshape(axes, axes)[:count, :count]
    if origin is not None:
        first[:count] = origin[:count]
    place: JsonDict = {"space directions": [None, *(along * spacing[:, None]), None]}
    if sides is not None:
        place["space units"] = 3 * [entries.get("distanceunits", "mm").strip("?") or "mm"]
    if origin is not None or matrix is not None:
        place |= {"space": "LPS", "space origin": first}
    return place
