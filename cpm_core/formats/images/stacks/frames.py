"""Frames: animated pictures (GIF, APNG, WebP), whose frames are points in time, and pictures that stand still."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from cpm_core.formats.common.printable import printable
from cpm_core.formats.images import raster
from cpm_core.formats.images.choice import FIRST, Choice
from cpm_core.formats.images.decoded import Decoded
from cpm_core.formats.images.stacks.stack import Stack, as_planes, plane_of

FORMAT = ""
READS = raster.READS


def reads(_head: bytes, _path: Path) -> bool:
    """Always true: this reader is the last one, and Pillow recognizes the format itself."""
    return True


def read(path: Path, choice: Choice = FIRST) -> Decoded:
    """Read a picture, or the frame of it that is chosen."""
    return raster.read(path) if choice == FIRST else plane_of(stack(path, choice), choice)


def stack(path: Path, _choice: Choice = FIRST) -> Stack:
    """Open an animated picture."""
    with raster.opened(path) as picture:
        rows, columns, frames = picture.height, picture.width, int(getattr(picture, "n_frames", 1))
        still = raster.shown(picture, path.name, alone=True) if frames == 1 else None
        (row, col), unit = ((1.0, 1.0), None) if still is None else (still.spacing, still.unit)
    if still is not None:
        rows, columns = still.values.shape

    def take(time: int, _channel: int, _first: int, _end: int) -> Decoded:
        with raster.opened(path) as picture:
            picture.seek(time)
            one = replace(raster.shown(picture, path.name, alone=True), spacing=(1.0, 1.0), unit=None)
        return as_planes(one, (1, *one.values.shape))

    return Stack(
        printable(path.name), (1, rows, columns), take, 4.0, frames, spacing=(row, row, col), unit=unit, word="frame"
    )
