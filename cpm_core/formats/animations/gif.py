"""GIF: an animation that all viewers show, in at most 256 colors a frame."""

from __future__ import annotations

import io
import struct
from pathlib import Path

import numpy as np
import PIL.Image

from cpm_core.formats.animations.frame_compression import changed, indexed
from cpm_core.numerics.types import Pixels

ANIMATES = {".gif": "animated GIF, which all viewers show"}

FASTEST = 50.0
"""Most frames a second that viewers show; they play a faster animation slowly."""

_FOREVER = b"!\xff\x0bNETSCAPE2.0\x03\x01\0\0\0"
_KEEP, _TRANSPARENT = 1 << 2, 1
_TABLE = 0x80
_MOST = 255
"""Colors of a frame; one more entry of its table is the transparent color."""


class GifAnimation:
    """A GIF that is written frame by frame, each with a palette of its own; see `animation.Animation`.

    Times are rounded to a hundredth of a second without accumulating errors. ValueError when the speed is more than
    viewers show, or the frames are too large.
    """

    def __init__(self, path: Path, shape: tuple[int, int], frames_per_second: float, comment: str = "") -> None:
        if frames_per_second > FASTEST:
            raise ValueError(
                f"A GIF shows at most {FASTEST:g} frames a second, not {frames_per_second:g}: choose fewer, or save as "
                "APNG (.png) or .mp4."
            )
        if max(shape) > 65535:
            raise ValueError(f"A GIF has at most 65535 rows and columns, not {max(shape)}: save a smaller view.")
        self._duration = 100.0 / frames_per_second
        self._count = 0
        self._last: Pixels | None = None
        self._stream = path.open("wb")
        self._stream.write(b"GIF89a" + struct.pack("<HHBBB", shape[1], shape[0], 0x70, 0, 0) + _FOREVER)
        if comment:
            self._stream.write(_comment(comment.encode("ascii")))

    def add(self, frame: Pixels) -> None:
        """Append a frame: the rectangle of it that has changed, and there only pixels that have."""
        top, left, bottom, right = changed(self._last, frame)
        part = frame[top:bottom, left:right]
        fresh = np.ones(part.shape[:2], dtype=np.bool_)
        if self._last is not None:
            fresh = (part != self._last[top:bottom, left:right]).any(axis=2)
            fresh[0, 0] = True  # a palette has at least one color
        found, palette = indexed(part[fresh][None], _MOST)
        indices = np.full(part.shape[:2], len(palette), dtype=np.uint8)  # the last one is transparent
        indices[fresh] = found[0]
        table, data = _parts(indices, palette)
        delay = round((self._count + 1) * self._duration) - round(self._count * self._duration)
        # the first frame is complete; with a transparent color readers would treat the whole animation as transparent
        control = (_KEEP | _TRANSPARENT, delay, len(palette)) if self._count else (_KEEP, delay, 0)
        self._stream.write(b"!\xf9\x04" + struct.pack("<BHBB", *control, 0))
        size = (len(table) // 3).bit_length() - 2
        self._stream.write(b"," + struct.pack("<4HB", left, top, right - left, bottom - top, _TABLE | size))
        self._stream.write(table + data)
        self._last, self._count = frame.copy(), self._count + 1

    def close(self) -> None:
        """End the file."""
        self._stream.write(b";")
        self._stream.close()

    def abandon(self) -> None:
        """Stop writing."""
        self._stream.close()


def _comment(text: bytes) -> bytes:
    """A comment in blocks that begin with their length, which is a byte."""
    blocks = (text[start : start + 255] for start in range(0, len(text), 255))
    return b"!\xfe" + b"".join(bytes([len(block)]) + block for block in blocks) + b"\0"


def _parts(indices: Pixels, palette: Pixels) -> tuple[bytes, bytes]:
    """Table of colors and compressed pixels of a picture, extracted from a GIF file of it."""
    picture = PIL.Image.fromarray(indices)
    picture.putpalette(palette.tobytes() + bytes(3))
    stream = io.BytesIO()
    picture.save(stream, format="GIF", interlace=0, optimize=False)
    content = stream.getvalue()
    start = 13
    table = content[start : start + 3 * (2 << (content[10] & 7))]
    start += len(table)
    while content[start : start + 1] == b"!":  # extensions: a mark, a kind and blocks that begin with their length
        start += 2
        while content[start]:
            start += 1 + content[start]
        start += 1
    return table, content[start + 10 : -1]
