"""Compression of frames: the rectangle that has changed, and a palette of at most 256 colors."""

from __future__ import annotations

import numpy as np
import PIL.Image
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.types import Pixels

MOST = 256
"""Colors that a palette holds."""

_KEPT = 64
"""Most vivid colors that are kept exactly, the most frequent ones: those of overlays."""

_VIVID = 40
"""Smallest difference of the largest and the smallest of red, green and blue in a vivid color."""

_DROPPED_BITS = 2
"""Bits of each color that are left out where the others are counted."""

_MOST_REPEATS = 64


def changed(last: Pixels | None, frame: Pixels) -> tuple[int, int, int, int]:
    """Top, left, bottom and right (exclusive) of the rectangle in which a frame (H, W, 3) differs from the last.

    All of the first frame, for which `last` is None; a single pixel where nothing has changed, because a frame must not
    be empty.
    """
    if last is None:
        return 0, 0, frame.shape[0], frame.shape[1]
    differs = (last != frame).any(axis=2)
    rows, cols = np.flatnonzero(differs.any(axis=1)), np.flatnonzero(differs.any(axis=0))
    if not len(rows):
        return 0, 0, 1, 1
    return int(rows[0]), int(cols[0]), int(rows[-1]) + 1, int(cols[-1]) + 1


def indexed(frame: Pixels, most: int = MOST) -> tuple[Pixels, Pixels]:
    """Convert a picture to indices of a palette of its own.

    Pictures of at most `most` colors are unchanged. Of others the most frequent vivid colors are kept exactly:
    particles and contours have a few pure colors but cover few pixels, so quantization would mix them with others.
    The rest of the palette is distributed over all other colors by median cut, with more weight on rare ones.

    Parameters
    ----------
    frame : ndarray of uint8, shape (H, W, 3)
        Red, green and blue.
    most : int
        Colors that the palette may have.

    Returns
    -------
    indices : ndarray of uint8, shape (H, W)
        Indices of the palette. There is no dithering, which would flicker from frame to frame.
    palette : ndarray of uint8, shape (P, 3)
        Colors.
    """
    packed = _packed(frame)
    colors = np.unique(packed)
    if len(colors) <= most:
        return np.searchsorted(colors, packed).astype(np.uint8).reshape(frame.shape[:2]), _unpacked(colors)
    vivid = np.ptp(frame.reshape(-1, 3), axis=1) >= _VIVID
    kept, frequency = np.unique(packed[vivid], return_counts=True)
    kept = np.sort(kept[np.argsort(-frequency, kind="stable")[:_KEPT]])
    bins = _packed(frame >> _DROPPED_BITS, 8 - _DROPPED_BITS)
    position = _places(bins)
    count = np.bincount(position)
    means = np.stack([np.bincount(position, frame[..., axis].ravel()) / count for axis in range(3)], axis=1)
    repeats = np.minimum(np.ceil(np.sqrt(count)), _MOST_REPEATS).astype(int)
    samples = np.repeat(np.rint(means).astype(np.uint8), repeats, axis=0)
    reduced = PIL.Image.fromarray(samples[None]).quantize(most - len(kept), PIL.Image.Quantize.MEDIANCUT)
    mixed = np.array(reduced.getpalette() or [], dtype=np.uint8).reshape(-1, 3)[: most - len(kept)]
    palette = np.concatenate([_unpacked(kept), mixed])
    nearest = np.asarray(scipy.spatial.cKDTree(palette).query(means)[1]).astype(np.uint8)
    indices = nearest[position]
    if len(kept):
        place = np.minimum(np.searchsorted(kept, packed[vivid]), len(kept) - 1)
        exact = kept[place] == packed[vivid]
        indices[np.flatnonzero(vivid)[exact]] = place[exact]
    return indices.reshape(frame.shape[:2]), palette


def _packed(frame: NDArray[np.integer], bits: int = 8) -> NDArray[np.int32]:
    """Red, green and blue of each pixel in one number."""
    red, green, blue = frame.reshape(-1, 3).astype(np.int32).T
    return np.asarray((red << 2 * bits) | (green << bits) | blue)


def _unpacked(colors: NDArray[np.int32]) -> Pixels:
    return np.stack([colors >> 16, colors >> 8 & 255, colors & 255], axis=1).astype(np.uint8)


def _places(bins: NDArray[np.int32]) -> NDArray[np.intp]:
    """Rank of each number among those that occur."""
    return np.asarray((np.cumsum(np.bincount(bins) > 0) - 1)[bins])
