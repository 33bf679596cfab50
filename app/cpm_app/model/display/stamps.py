"""Many small pictures stamped into a large one, without the interpreter's lock."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics import Array, compiled
from cpm_core.numerics.jit import inlined

Colors = NDArray[np.uint32]
"""Pixels: alpha, red, green and blue in a byte each, from the highest one down, the colors multiplied by alpha."""

LANES = 8
"""The width of stamps is a multiple of this, so that the compiler lays so many pixels at a time [px]."""

_RED_AND_BLUE, _ALPHA_AND_GREEN = np.uint32(0x00FF00FF), np.uint32(0xFF00FF00)
_BYTE, _THREE_BYTES, _WHOLE = np.uint32(8), np.uint32(24), np.uint32(256)


@compiled
def stamp(
    picture: Colors,
    positions: Array,
    scale: Array,
    origin: Array,
    stamps: Colors,
    marks: NDArray[np.uint8],
    opaque: Array,
) -> None:
    """Stamp into a picture, the later over the earlier ones, what lies inside it as a whole.

    Parameters
    ----------
    picture : ndarray of uint32, shape (H, W)
        Where they are stamped.
    positions : ndarray, shape (N, 2)
        Their centers (row, col), which are multiplied by `scale` and moved by `origin`, shape (2,) each [px].
    stamps : ndarray of uint32, shape (K, S, S or more)
        Squares, filled up to the right by pixels without color.
    marks : ndarray of uint8, shape (N,)
        Which square is stamped.
    opaque : ndarray, shape (N,)
        The opacity of each, from 0 to 1.
    """
    height, width = picture.shape
    _, side, wide = stamps.shape
    for i in range(positions.shape[0]):
        down = np.floor(positions[i, 0] * scale[0] + origin[0] - 0.5 * side + 0.5)
        right = np.floor(positions[i, 1] * scale[1] + origin[1] - 0.5 * side + 0.5)
        if not (0 <= down <= height - side and 0 <= right <= width - wide):
            continue
        # without a sign, and of 32 bits: else the inner loop is not made of vectors
        top, left, mark, strength = np.uint64(down), np.uint64(right), np.uint64(marks[i]), np.uint32(256.0 * opaque[i])
        for row in range(np.uint64(side)):
            for col in range(np.uint64(wide)):
                ink = _multiplied(stamps[mark, row, col], strength)
                below = picture[top + row, left + col]
                picture[top + row, left + col] = np.uint32(ink + _multiplied(below, _WHOLE - (ink >> _THREE_BYTES)))


@inlined
def _multiplied(color: np.uint32, factor: np.uint32) -> np.uint32:
    """A color times a factor of at most 256, over 256; two bytes are multiplied at a time."""
    one = np.uint32(np.uint32(color & _RED_AND_BLUE) * factor) >> _BYTE
    other = np.uint32(np.uint32(color >> _BYTE) & _RED_AND_BLUE) * factor
    return np.uint32(np.uint32(one & _RED_AND_BLUE) | np.uint32(other & _ALPHA_AND_GREEN))


def load() -> None:
    """Compile the loop, or load it, so that the first picture of a run does not wait for that."""
    color, nothing = np.zeros((1, 1, LANES), np.uint32), np.empty((0, 2))
    stamp(color[0], nothing, np.ones(2), np.zeros(2), color, np.empty(0, np.uint8), np.empty(0))
