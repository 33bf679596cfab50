"""Content: the numbers of a volume behind a header or in a file beside it, packed or not, and no more than it names."""

from __future__ import annotations

import bz2
import math
import zlib
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from cpm_core.formats.images.decoded import UnreadableError
from cpm_core.formats.images.stacks.stack import check_content, check_memory
from cpm_core.parameters.quotation import shown

Packing = Literal["raw", "deflate", "bzip2"]

_PART = 2**22
"""Bytes that are read at once."""

_EITHER_HEAD = 47
"""Tells zlib to take the heads of zlib and of gzip."""


def values_of(
    file: Path, offset: int, shape: tuple[int, ...], kind: np.dtype[Any], packing: Packing = "raw"
) -> NDArray[Any]:
    """Values in a file from a place on.

    Parameters
    ----------
    file : Path
        The file.
    offset : int
        Where they begin; below 0 they are the last ones in the file.
    shape : tuple of int
        Their number along each axis, the slowest first.
    kind : dtype
        Their type.
    packing : {"raw", "deflate", "bzip2"}
        How they are packed. What is not packed is read where it is used.

    Raises
    ------
    EOFError
        When there are fewer.
    UnreadableError
        When they do not fit into memory.
    """
    needed = math.prod(shape) * kind.itemsize
    if packing == "raw":
        start = file.stat().st_size - needed if offset < 0 else offset
        if start < 0 or file.stat().st_size < start + needed:
            raise EOFError(f"{file.name} names more bytes than it has.")
        return np.memmap(file, kind, "r", start, shape)
    if packing == "deflate":
        check_content(file, needed)
    check_memory(shape, kind.itemsize, file.name)
    return np.frombuffer(_unpacked(file, max(offset, 0), needed, packing), kind).reshape(shape)


def _unpacked(file: Path, offset: int, needed: int, packing: Packing) -> bytearray:
    found = bytearray()

    def opened() -> Any:
        return zlib.decompressobj(_EITHER_HEAD) if packing == "deflate" else bz2.BZ2Decompressor()

    with file.open("rb") as stream:
        stream.seek(offset)
        unpacker, part, ended = opened(), stream.read(_PART), False
        while part and len(found) < needed + (not ended):  # the checksum at the end shows whether the values are sound
            found += unpacker.decompress(part, needed + 1 - len(found))
            ended = unpacker.eof
            part = unpacker.unconsumed_tail if packing == "deflate" else b""
            if ended:  # there may be several packed parts one behind the other
                part = unpacker.unused_data
                unpacker = opened()
            if not part:
                part = stream.read(_PART)
    if len(found) < needed + (not ended):
        raise EOFError(f"{file.name} names more bytes than it has.")
    del found[needed:]
    return found


def beside(header: Path, named: str) -> Path:
    """The file beside a header that it names; UnreadableError for files elsewhere, and for what is no file."""
    place = Path(named)
    data = header.parent / place
    if "\0" in named or place.is_absolute() or ".." in place.parts or not data.is_file():
        raise UnreadableError(
            f"{header.name} keeps its values in {shown(place.name)}, which is not beside it: put both in one folder."
        )
    return data
