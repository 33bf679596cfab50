"""Run lengths: masks as COCO holds them, down one column after the other, plain or compressed to text."""

from __future__ import annotations

from typing import Any

import numpy as np

from cpm_core.formats.images.decoded import MAXIMUM_PIXELS
from cpm_core.numerics.types import Mask

_FIRST = 48
"""Letter of the value 0."""


def mask_of(plain: Any) -> Mask:
    """The mask of an object with ``size`` and ``counts``; ValueError when it is none."""
    height, width = (int(side) for side in plain["size"])
    counts = plain["counts"]
    lengths = _unpacked(counts) if isinstance(counts, str) else np.array(counts, dtype=np.int64).reshape(-1)
    if (
        min(height, width) < 1
        or height * width > MAXIMUM_PIXELS
        or lengths.sum() != height * width
        or lengths.min() < 0
    ):
        raise ValueError("run lengths do not fill the image")
    values = np.arange(len(lengths)) % 2 == 1
    return np.repeat(values, lengths).reshape(width, height).T


def _unpacked(text: str) -> np.ndarray[Any, np.dtype[np.int64]]:
    """Lengths of the runs of compressed text.

    A letter holds five bits, the lowest first, and whether another follows; from the fourth length on, each is told
    by how much it differs from the one before the last.
    """
    lengths: list[int] = []
    value = shift = 0
    for letter in text:
        bits = ord(letter) - _FIRST
        if not 0 <= bits < 64 or shift > 60:
            raise ValueError("run lengths hold a letter that means nothing")
        value |= (bits & 31) << shift
        shift += 5
        if not bits & 32:
            if bits & 16:
                value -= 1 << shift
            lengths.append(value + (lengths[-2] if len(lengths) > 2 else 0))
            value = shift = 0
    return np.array(lengths, dtype=np.int64)
