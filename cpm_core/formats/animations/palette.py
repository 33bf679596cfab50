"""Palette: the colors that a picture with at most 256 of them is given."""

from __future__ import annotations

import numpy as np
import PIL.Image
import scipy
from numpy.typing import NDArray

from cpm_core.numerics.types import Pixels

MOST = 256
"""Colors that a palette holds."""

_KEPT = 64
"""Vivid colors that are kept as they are, the most frequent of them: those that something is drawn in."""

_VIVID = 40
"""Least difference of the strongest and the weakest of red, green and blue in a vivid color."""

_DROPPED_BITS = 2
"""Bits of each color that are left out where the others are counted."""

_MOST_REPEATS = 64


def indexed(frame: Pixels, most: int = MOST) -> tuple[Pixels, Pixels]:
    """Turn a picture into indices of a palette of its own.

    Pictures of no more colors stay as they are. Of others the most frequent vivid colors do, for particles and
    contours, drawn in a few pure ones, cover hardly any of the pixels and would otherwise be mixed with what they lie
    on; the rest of the palette is shared out among all other colors, the rarer ones favoured, by median cut.

    Parameters
    ----------
    frame : ndarray of uint8, shape (H, W, 3)
        Red, green and blue.
    most : int
        Colors that the palette may have.

    Returns
    -------
    indices : ndarray of uint8, shape (H, W)
        Indices of the palette. Neighbors are not mixed to imitate colors, which would flicker from frame to frame.
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
    """Place of each number among those that occur."""
    return np.asarray((np.cumsum(np.bincount(bins) > 0) - 1)[bins])
