"""Packing: pixels of a TIFF that are stored in a way which tifffile unpacks only with more packages than CPM needs.

The library libtiff, a part of Pillow, unpacks the bytes; but Pillow cuts and reinterprets pixels as it reads them. So
each part of an image is given to it as a picture of single bytes, and what the bytes mean is left to tifffile: the
pixels are the same, however they are packed.
"""

from __future__ import annotations

import io
import struct
from functools import cache
from math import ceil

import numpy as np
import PIL.Image
import tifffile
from numpy.typing import NDArray

_NONE, _LZW, _ZSTD = 1, 5, 50000
_BY_LIBTIFF = frozenset({_NONE, _LZW, 8, 32773, 32946, _ZSTD})
"""Compressions that libtiff unpacks byte by byte: also deflate and PackBits, which tifffile unpacks as well."""

_ONE_BYTE = bytes.fromhex("28b52ffd20010900002a")
"""The byte 42 as Zstandard packs it."""

_UNSIGNED, _FLOAT = 1, 3
_DIFFERENCES_OF_FLOATS = 3
_SHORT, _LONG = 3, 4


def needs_unpacking(page: tifffile.TiffPage) -> bool:
    """Whether `unpacked` must take the place of tifffile's own `asarray`."""
    if page.compression not in _BY_LIBTIFF or not isinstance(page.bitspersample, int):
        return False
    if page.compression == _ZSTD and not _unpacks_zstd():
        return False
    return page.compression in (_LZW, _ZSTD) or _is_float_packed(page) or _is_odd(page)


@cache
def _unpacks_zstd() -> bool:
    """Whether the libtiff of this Pillow knows Zstandard; those of Pillow before 12 may not."""
    try:
        return _bytes(_ONE_BYTE, _ZSTD, 1, 1, 1) == _ONE_BYTE[-1:]
    except OSError:
        return False


def unpacked(page: tifffile.TiffPage) -> NDArray[np.generic]:
    """Pixels of a page that `needs_unpacking`, in the shape that tifffile gives them.

    The page's own entries on its packing are changed, since what is left to tifffile is unpacked. Raises anything on
    damaged pages.
    """
    assert page.dtype is not None
    packing, order, bits = int(page.compression), int(page.fillorder), int(page.bitspersample)
    floats, odd = _is_float_packed(page), _is_odd(page)
    samples = page.samplesperpixel if page.planarconfig == 1 else 1
    across = (page.tilewidth if page.is_tiled else page.imagewidth) * samples
    length = page.tilelength if page.is_tiled else page.rowsperstrip
    row = ceil(across * bits / 8)
    number = page.dtype.newbyteorder(page.parent.byteorder)
    page.compression, page.fillorder = tifffile.COMPRESSION.NONE, tifffile.FILLORDER.MSB2LSB
    if floats:
        page.predictor = tifffile.PREDICTOR.NONE
    if odd:
        page.bitspersample = 8 * number.itemsize
    pixels = np.zeros(page.shaped, page.dtype)
    stream = page.parent.filehandle
    for index, (offset, count) in enumerate(zip(page.dataoffsets, page.databytecounts, strict=True)):
        if not count:
            continue
        rows = length if page.is_tiled else min(length, page.imagelength - index * length % _covered(page))
        stream.seek(offset)
        content = _bytes(stream.read(count), packing, order, rows, row)
        if floats:
            content = _summed(content, rows, samples, number)
        if odd:
            content = _widened(content, rows, across, bits, number)
        part, (plane, _, top, left, _), shape = page.decode(content, index)
        assert part is not None
        height, width = min(shape[1], page.imagelength - top), min(shape[2], page.imagewidth - left)
        pixels[plane, 0, top : top + height, left : left + width] = part[0, :height, :width]
    return pixels.reshape(page.shape)


def _is_float_packed(page: tifffile.TiffPage) -> bool:
    return page.predictor == _DIFFERENCES_OF_FLOATS and page.sampleformat == _FLOAT


def _is_odd(page: tifffile.TiffPage) -> bool:
    """Whether samples are packed so that they do not begin with a byte."""
    return page.sampleformat == _UNSIGNED and page.bitspersample < 32 and page.bitspersample not in (1, 8, 16)


def _covered(page: tifffile.TiffPage) -> int:
    """Rows that the strips of one channel cover, the last one taken as whole."""
    return int(ceil(page.imagelength / page.rowsperstrip) * page.rowsperstrip)


def _summed(content: bytes, rows: int, samples: int, number: np.dtype[np.generic]) -> bytes:
    """Real numbers from differences of their bytes, of which the highest stand first in each row."""
    packed = np.frombuffer(content, np.uint8).reshape(rows, -1, samples).cumsum(axis=1, dtype=np.uint8)
    ordered = packed.reshape(rows, number.itemsize, -1).transpose(0, 2, 1)
    return np.ascontiguousarray(ordered).view(number.newbyteorder(">")).astype(number).tobytes()


def _widened(content: bytes, rows: int, across: int, bits: int, number: np.dtype[np.generic]) -> bytes:
    """Whole numbers of `bits` bits, the rows of which begin with a byte, in whole bytes each.

    Their highest bit comes first, whatever the order of bytes in the file; but numbers of three bytes keep to that.
    """
    if bits == 24 and number.newbyteorder("<") == number:
        swapped = np.frombuffer(content, np.uint8).reshape(-1, 3)[:, ::-1]
        content = swapped.tobytes()
    each = np.unpackbits(np.frombuffer(content, np.uint8).reshape(rows, -1), axis=1)[:, : across * bits]
    values = each.reshape(rows, across, bits) @ (1 << np.arange(bits - 1, -1, -1, dtype=np.uint32))
    return values.astype(number).tobytes()


def _bytes(packed: bytes, packing: int, order: int, rows: int, columns: int) -> bytes:
    """Unpack one part, which becomes rows of bytes."""
    with PIL.Image.open(io.BytesIO(_as_picture(packed, packing, order, rows, columns)), formats=("TIFF",)) as picture:
        return picture.tobytes()


def _as_picture(packed: bytes, packing: int, order: int, rows: int, columns: int) -> bytes:
    """A TIFF of one strip, with a byte a pixel."""
    entries = (
        (256, _LONG, columns),
        (257, _LONG, rows),
        (258, _SHORT, 8),
        (259, _SHORT, packing),
        (262, _SHORT, 1),
        (266, _SHORT, order),
        (273, _LONG, 8),
        (277, _SHORT, 1),
        (278, _LONG, rows),
        (279, _LONG, len(packed)),
    )
    directory = 8 + len(packed) + len(packed) % 2
    table = b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in entries)
    head = struct.pack("<2sHI", b"II", 42, directory)
    return head + packed.ljust(directory - 8, b"\0") + struct.pack("<H", len(entries)) + table + bytes(4)
