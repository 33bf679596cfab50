"""The potential of the fixed charges, eq. (7), exact, as one zero-padded convolution."""

from __future__ import annotations

from functools import reduce

import numpy as np
import scipy

from cpm_core.numerics.types import Array


def convolved_potential(edge_map: Array) -> Array:
    r"""Potential of the fixed charges of an image, of which the field of eq. (8) is the slope.

    ``V(r) = sum_k -f_k / ((D - 1) |r - R_k|^(D - 1))``, which is eq. (7) in the plane: below zero everywhere, and
    lowest on edges. No pixel acts on itself.

    Parameters
    ----------
    edge_map : ndarray, shape (\*shape)
        Edge strength ``f`` of every pixel [gray levels / px]; of two axes at least.

    Returns
    -------
    ndarray, shape (\*shape)
        Potential; the transforms are done in single precision, which leaves 1e-6 of its largest value.
    """
    dimension, last = edge_map.ndim, edge_map.ndim - 1
    padded = tuple(scipy.fft.next_fast_len(2 * n - 1, axis == last) for axis, n in enumerate(edge_map.shape))
    offsets = np.meshgrid(*(size * np.fft.fftfreq(size) for size in padded), indexing="ij", sparse=True)
    away = reduce(np.hypot, offsets).astype(np.float32)
    away[(0,) * dimension] = np.inf
    spectrum = scipy.fft.rfftn(edge_map.astype(np.float32), padded, workers=-1)
    spectrum *= scipy.fft.rfftn(1.0 / ((dimension - 1) * away ** (dimension - 1)), workers=-1)
    inner = tuple(slice(n) for n in edge_map.shape)
    potential: Array = scipy.fft.irfftn(spectrum, padded, workers=-1)[inner].astype(float)
    return -potential
