"""The network: a small U-Net, run by matrix products alone.

Rectified convolutions of 3 x 3 pixels at five resolutions, each half as fine as the one before; on the way back the
finer maps are concatenated (Ronneberger, Fischer and Brox 2015, doi:10.1007/978-3-319-24574-4_28). It gives several
answers at once, as a click may mean several objects, and predicts the overlap of each with the intended object.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files

import numpy as np
import scipy

from cpm_core.numerics.parallel import limit_blas
from cpm_core.numerics.types import Single, record

_ENCODER_LAYERS = (1, 2, 2, 2, 2)
"""Number of convolutions at each resolution, the finest first."""

_DECODER_LAYERS = ((3, 2), (2, 2), (1, 1), (0, 1))
"""Resolution and number of convolutions of each level on the way back."""


_BAND_SIZE = 1 << 17
"""Numbers in the band of rows that a convolution reads at once, so that they stay in the cache of a core."""


@record
class Network:
    """A network of given weights.

    Attributes
    ----------
    weights : mapping of str to ndarray of float32
        Matrices of layers, shape (outputs, inputs), where the inputs of a convolution are rows, columns and maps; and
        their offsets, shape (outputs,), under their names with ``.offset``.
    """

    weights: Mapping[str, Single]

    @limit_blas()
    def __call__(self, maps: Single) -> tuple[Single, Single]:
        """Answer to input maps, shape (C, H, W), with sides divisible by 16.

        Returns
        -------
        tuple of ndarray of float32
            For each of N answers the probability of each pixel that it lies in the object, shape (N, H, W), and the
            estimated overlap (intersection over union) with the object, shape (N,). The first answer is the likeliest
            one; the others, which differ from one another, are of use only for a prompt without a previous mask.
        """
        finer = []
        for level, count in enumerate(_ENCODER_LAYERS):
            if level:
                finer.append(maps)
                maps = np.maximum(maps[:, ::2], maps[:, 1::2])
                maps = np.maximum(maps[..., ::2], maps[..., 1::2])
            for number in range(count):
                maps = self._convolve_rectified(maps, f"down{level}.{number}")
        maps = maps + np.maximum(self._apply_dense(maps.mean((1, 2)), "context"), 0.0)[:, None, None]
        hidden = np.maximum(self._apply_dense(np.concatenate([maps.mean((1, 2)), maps.max((1, 2))]), "overlap.0"), 0.0)
        overlaps = scipy.special.expit(self._apply_dense(hidden, "overlap.1"))
        for level, count in _DECODER_LAYERS:
            maps = np.concatenate([_upsample(self._mix_maps(maps, f"mix{level}")), finer[level]])
            for number in range(count):
                maps = self._convolve_rectified(maps, f"up{level}.{number}")
        return scipy.special.expit(self._mix_maps(maps, "out")), overlaps

    def _convolve_rectified(self, maps: Single, layer: str) -> Single:
        """Convolve maps by 3 x 3 pixels with zeros beyond the border, and rectify.

        Maps shifted by one column lie next to each other, so that the three columns are one product; a shift by one row
        is an offset in them.
        """
        count, height, width = maps.shape
        each, offset = self.weights[layer].reshape(-1, 3, 3 * count), self.weights[layer + ".offset"][:, None]
        found = np.empty((len(each), height, width), np.float32)
        rows = max(_BAND_SIZE // (3 * count * width), 1)
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

    def _mix_maps(self, maps: Single, layer: str) -> Single:
        """Mix maps to weighted sums at each pixel."""
        out = self.weights[layer] @ maps.reshape(len(maps), -1) + self.weights[layer + ".offset"][:, None]
        return out.reshape(-1, *maps.shape[1:])

    def _apply_dense(self, vector: Single, layer: str) -> Single:
        return self.weights[layer] @ vector + self.weights[layer + ".offset"]


@cache
def load_trained_network() -> Network:
    """Load the network with the weights that come with this package; `weights.md` states their origin."""
    with files("cpm_core.objects.prior").joinpath("weights.npz").open("rb") as file, np.load(file) as stored:
        return Network({name: stored[name].astype(np.float32) for name in stored.files})


def _upsample(maps: Single) -> Single:
    """Upsample maps by two along both sides, interpolated linearly."""
    for _ in range(2):  # each time along the last axis, which becomes the one before it
        quarter = 0.25 * maps
        most = maps - quarter
        finer = np.empty((*maps.shape[:-1], 2 * maps.shape[-1]), np.float32)
        finer[..., 0], finer[..., -1] = maps[..., 0], maps[..., -1]
        np.add(most[..., 1:], quarter[..., :-1], out=finer[..., 2::2])
        np.add(most[..., :-1], quarter[..., 1:], out=finer[..., 1:-1:2])
        maps = finer.swapaxes(1, 2)
    return maps
