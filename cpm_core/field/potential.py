"""The potential of the fixed charges, eq. (7), exact, as one zero-padded convolution."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.numerics.types import Array


def convolved_potential(edge_map: Array) -> Array:
    """Potential of the fixed charges of an image, of which the field of eq. (8) is the slope.

    ``V(r) = sum_k -f_k / |r - R_k|``: below zero everywhere, and lowest on edges. No pixel acts on itself.

    Parameters
    ----------
    edge_map : ndarray, shape (H, W)
        Edge strength ``f`` of every pixel [grey levels / px].

    Returns
    -------
    ndarray, shape (H, W)
        Potential; the transforms are done in single precision, which leaves 1e-6 of its largest value.
    """
    height, width = edge_map.shape
    padded = (scipy.fft.next_fast_len(2 * height - 1), scipy.fft.next_fast_len(2 * width - 1, True))
    row, col = (size * np.fft.fftfreq(size) for size in padded)
    away = np.hypot(row[:, None], col).astype(np.float32)
    away[0, 0] = np.inf
    spectrum = scipy.fft.rfft2(edge_map.astype(np.float32), padded, workers=-1)
    spectrum *= scipy.fft.rfft2(1.0 / away, workers=-1)
    potential: Array = scipy.fft.irfft2(spectrum, padded, workers=-1)[:height, :width].astype(float)
    return -potential
