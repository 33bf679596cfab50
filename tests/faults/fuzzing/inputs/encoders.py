"""Encoders of sound files from arrays, for samples."""

from __future__ import annotations

import io
from typing import Any, NamedTuple

import numpy as np
import PIL.Image
import tifffile


class Sample(NamedTuple):
    """A sound file: the suffix of its name, and its bytes."""

    suffix: str
    content: bytes


def picture(values: Any, kind: str, mode: str | None = None, **options: Any) -> bytes:
    """A picture of Pillow."""
    made = PIL.Image.fromarray(values)
    stream = io.BytesIO()
    (made.convert(mode) if mode else made).save(stream, format=kind, **options)
    return stream.getvalue()


def tiff(values: Any, **options: Any) -> bytes:
    """A TIFF."""
    stream = io.BytesIO()
    kinds = {name: options.pop(name) for name in ("bigtiff", "byteorder", "imagej", "ome") if name in options}
    with tifffile.TiffWriter(stream, **kinds) as writer:
        writer.write(values, **options)
    return stream.getvalue()


def numpy_array(values: Any) -> bytes:
    """An array of NumPy."""
    stream = io.BytesIO()
    np.save(stream, values)
    return stream.getvalue()
