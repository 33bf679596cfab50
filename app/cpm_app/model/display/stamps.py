"""Many small pictures stamped into a large one, without the interpreter's lock."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics import Array, compiled
from cpm_core.numerics.jit import inlined

Colors = NDArray[np.uint32]
"""Pixels: alpha, red, green and blue in a byte each, from the highest one down, the colors multiplied by alpha."""

STAMP_LANES = 8
"""The width of stamps is a multiple of this, so that the compiler can vectorize over this many pixels [px]."""

_RED_BLUE_MASK = np.uint32(0x00FF00FF)
"""Bytes of red and blue in a pixel."""

_ALPHA_GREEN_MASK = np.uint32(0xFF00FF00)
"""Bytes of alpha and green in a pixel."""

_BYTE_BITS = np.uint32(8)
"""Bits in a byte."""

_ALPHA_SHIFT = np.uint32(24)
"""Bits below the byte of alpha."""

_FULL_OPACITY = np.uint32(256)
"""Factor that leaves a color as it is."""


@compiled
def stamp_pictures(
    picture: Colors,
    positions: Array,
    scale: Array,
    origin: Array,
    stamps: Colors,
    marks: NDArray[np.uint8],
    opaque: Array,
) -> None:
    """Stamp small pictures into a large one, later over earlier ones; any that would cross its border is left out.

    Parameters
    ----------
    picture : ndarray of uint32, shape (H, W)
        The large picture, which is changed.
    positions : ndarray, shape (N, 2)
        Centers (row, col) [px].
    scale, origin : ndarray, shape (2,)
        Position (row, col) in the picture is ``position * scale + origin`` [px].
    stamps : ndarray of uint32, shape (K, S, S or more)
        Squares, padded on the right with transparent pixels.
    marks : ndarray of uint8, shape (N,)
        Index of the square that is stamped.
    opaque : ndarray, shape (N,)
        Opacity of each, from 0 to 1.
    """
    height, width = picture.shape
    _, side, wide = stamps.shape
    for i in range(positions.shape[0]):
        down = np.floor(positions[i, 0] * scale[0] + origin[0] - 0.5 * side + 0.5)
        right = np.floor(positions[i, 1] * scale[1] + origin[1] - 0.5 * side + 0.5)
        if not (0 <= down <= height - side and 0 <= right <= width - wide):
            continue
        # unsigned, and of 32 bits: otherwise the inner loop is not vectorized
        top, left, mark, strength = np.uint64(down), np.uint64(right), np.uint64(marks[i]), np.uint32(256.0 * opaque[i])
        for row in range(np.uint64(side)):
            for col in range(np.uint64(wide)):
                ink = _multiply_color(stamps[mark, row, col], strength)
                below = picture[top + row, left + col]
                covered = _multiply_color(below, _FULL_OPACITY - (ink >> _ALPHA_SHIFT))
                picture[top + row, left + col] = np.uint32(ink + covered)


@inlined
def _multiply_color(color: np.uint32, factor: np.uint32) -> np.uint32:
    """Multiply a color by a factor of at most 256 and divide by 256; two bytes are multiplied at a time."""
    one = np.uint32(np.uint32(color & _RED_BLUE_MASK) * factor) >> _BYTE_BITS
    other = np.uint32(np.uint32(color >> _BYTE_BITS) & _RED_BLUE_MASK) * factor
    return np.uint32(np.uint32(one & _RED_BLUE_MASK) | np.uint32(other & _ALPHA_GREEN_MASK))


def compile_stamping() -> None:
    """Compile the loop, or load it, so that the first picture of a run does not wait for it."""
    color, nothing = np.zeros((1, 1, STAMP_LANES), np.uint32), np.empty((0, 2))
    stamp_pictures(color[0], nothing, np.ones(2), np.zeros(2), color, np.empty(0, np.uint8), np.empty(0))
