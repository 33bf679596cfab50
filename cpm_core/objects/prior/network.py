"""The network of the prior: a small U-Net, run by matrix products alone.

Convolutions of 3 x 3 pixels, rectified, at five resolutions, each half as fine as the one before; on the way back the
finer maps join again (Ronneberger, Fischer and Brox 2015, doi:10.1007/978-3-319-24574-4_28). A second output estimates
the overlap of the answer with the object that is meant.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files

import numpy as np
import scipy

from cpm_core.numerics.types import Single, record

_DOWN, _UP = (1, 2, 2, 2, 2), ((3, 2), (2, 2), (1, 1), (0, 1))
"""Convolutions at each resolution, the finest first; and on the way back, each with its resolution."""

_BAND = 1 << 17
"""Numbers in a band of rows that a convolution reads, which then stay in the cache of a core."""


@record
class Network:
    """A network of given weights.

    Attributes
    ----------
    weights : mapping of str to ndarray of float32
        Matrices of layers, shape (outputs, inputs): of a convolution the inputs are rows, columns and maps; and under
        their names with ``.offset`` what is added, shape (outputs,).
    """

    weights: Mapping[str, Single]

    def __call__(self, maps: Single) -> tuple[Single, float]:
        """Answer to input maps, shape (C, H, W), with sides divisible by 16.

        Returns
        -------
        tuple of ndarray of float32 and float
            Probability of each pixel that it lies in the object, shape (H, W), and the estimated overlap
            (intersection over union) of that answer with the object.
        """
        finer = []
        for level, count in enumerate(_DOWN):
            if level:
                finer.append(maps)
                maps = np.maximum(maps[:, ::2], maps[:, 1::2])
                maps = np.maximum(maps[..., ::2], maps[..., 1::2])
            for number in range(count):
                maps = self._convolved(maps, f"down{level}.{number}")
        maps = maps + np.maximum(self._product(maps.mean((1, 2)), "context"), 0.0)[:, None, None]
        hidden = np.maximum(self._product(np.concatenate([maps.mean((1, 2)), maps.max((1, 2))]), "overlap.0"), 0.0)
        overlap = float(scipy.special.expit(self._product(hidden, "overlap.1")[0]))
        for level, count in _UP:
            maps = np.concatenate([_doubled(_doubled(self._mixed(maps, f"mix{level}"), 1), 2), finer[level]])
            for number in range(count):
                maps = self._convolved(maps, f"up{level}.{number}")
        return scipy.special.expit(self._mixed(maps, "out")[0]), overlap

    def _convolved(self, maps: Single, layer: str) -> Single:
        """Convolution of 3 x 3 pixels with zeros beyond the border, rectified.

        Maps shifted by one column lie next to each other, so that the three columns are one product; a shift by one row
        is an offset in them.
        """
        count, height, width = maps.shape
        each, offset = self.weights[layer].reshape(-1, 3, 3 * count), self.weights[layer + ".offset"][:, None]
        found = np.empty((len(each), height, width), np.float32)
        rows = max(_BAND // (3 * count * width), 1)
        for first in range(0, height, rows):
            end = min(first + rows, height)
            top, bottom = max(first - 1, 0), min(end + 1, height)
            columns = np.zeros((3, count, end - first + 2, width), np.float32)
            there, band = columns[:, :, top - first + 1 : bottom - first + 1], maps[:, top:bottom]
            there[0, ..., 1:], there[1], there[2, ..., :-1] = band[..., :-1], band, band[..., 1:]
            flat, size = columns.reshape(3 * count, -1), (end - first) * width
            out = each[:, 0] @ flat[:, :size]
            for row in (1, 2):
                out += each[:, row] @ flat[:, row * width : row * width + size]
            out += offset
            np.maximum(out.reshape(-1, end - first, width), 0.0, out=found[:, first:end])
        return found

    def _mixed(self, maps: Single, layer: str) -> Single:
        """Weighted sums over the maps at each pixel."""
        out = self.weights[layer] @ maps.reshape(len(maps), -1) + self.weights[layer + ".offset"][:, None]
        return out.reshape(-1, *maps.shape[1:])

    def _product(self, vector: Single, layer: str) -> Single:
        return self.weights[layer] @ vector + self.weights[layer + ".offset"]


@cache
def trained() -> Network:
    """The network with the weights that come with this package; `weights.md` has their origin."""
    with files("cpm_core.objects.prior").joinpath("weights.npz").open("rb") as file, np.load(file) as stored:
        return Network({name: stored[name].astype(np.float32) for name in stored.files})


def _doubled(maps: Single, axis: int) -> Single:
    """Twice as many pixels along an axis, interpolated linearly."""
    last = maps.shape[axis] - 1
    before = np.concatenate([maps.take([0], axis), maps.take(range(last), axis)], axis)
    after = np.concatenate([maps.take(range(1, last + 1), axis), maps.take([last], axis)], axis)
    pairs = np.stack([0.75 * maps + 0.25 * before, 0.75 * maps + 0.25 * after], axis + 1)
    return np.asarray(pairs.reshape(*maps.shape[:axis], -1, *maps.shape[axis + 1 :]), np.float32)
