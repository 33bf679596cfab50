"""APNG: an animation in full color, which browsers show; other programs show its first frame."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
import PIL.Image

from cpm_core.formats.animations.frame_compression import changed
from cpm_core.numerics.types import Pixels

ANIMATES = {
    ".png": "animated PNG in full color, which browsers show",
    ".apng": "animated PNG in full color, which browsers show",
}

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_LARGEST = 65535


class ApngAnimation:
    """An APNG that is written frame by frame; see `animation.Animation`."""

    def __init__(self, path: Path, shape: tuple[int, int], frames_per_second: float, comment: str = "") -> None:
        self._delay = Fraction(1.0 / frames_per_second).limit_denominator(_LARGEST)
        self._count = self._sequence = 0
        self._last: Pixels | None = None
        self._stream = path.open("wb")
        self._stream.write(_SIGNATURE)
        self._chunk(b"IHDR", struct.pack(">IIBBBBB", shape[1], shape[0], 8, 2, 0, 0, 0))
        if comment:
            self._chunk(b"tEXt", b"Description\0" + comment.encode("ascii"))
        self._counter = self._stream.tell()
        self._chunk(b"acTL", struct.pack(">II", 0, 0))  # the number of frames is filled in at the end

    def add(self, frame: Pixels) -> None:
        """Append a frame: the rectangle of it that has changed."""
        top, left, bottom, right = changed(self._last, frame)
        delay = (self._delay.numerator, self._delay.denominator)
        control = struct.pack(">4I2HBB", right - left, bottom - top, left, top, *delay, 0, 0)
        self._chunk(b"fcTL", self._numbered(control))
        for data in _pixels(np.ascontiguousarray(frame[top:bottom, left:right])):
            if self._count:
                self._chunk(b"fdAT", self._numbered(data))
            else:
                self._chunk(b"IDAT", data)
        self._last, self._count = frame.copy(), self._count + 1

    def close(self) -> None:
        """End the file."""
        self._chunk(b"IEND", b"")
        self._stream.seek(self._counter)
        self._chunk(b"acTL", struct.pack(">II", self._count, 0))
        self._stream.close()

    def abandon(self) -> None:
        """Stop writing."""
        self._stream.close()

    def _numbered(self, content: bytes) -> bytes:
        self._sequence += 1
        return struct.pack(">I", self._sequence - 1) + content

    def _chunk(self, kind: bytes, content: bytes) -> None:
        self._stream.write(struct.pack(">I", len(content)) + kind + content)
        self._stream.write(struct.pack(">I", zlib.crc32(kind + content)))


def _pixels(frame: Pixels) -> Iterator[bytes]:
    """Compressed pixels of a picture, extracted from a PNG file of it."""
    stream = io.BytesIO()
    PIL.Image.fromarray(frame).save(stream, format="PNG")
    content, start = stream.getvalue(), len(_SIGNATURE)
    while start < len(content):
        length, kind = struct.unpack_from(">I4s", content, start)
        if kind == b"IDAT":
            yield content[start + 8 : start + 8 + length]
        start += 12 + length
