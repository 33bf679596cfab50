"""The electric field of eq. (8), exact, as one zero-padded convolution."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def convolved_field(edge_map: ArrayLike, exponent: float | None = None) -> Array:
    r"""Electric field of the fixed charges, exact to rounding.

    The sum of eq. (8) is a convolution; computed with Fourier transforms on a grid padded with zeros to at least twice
    the size, nothing wraps around.

    Parameters
    ----------
    edge_map : array_like, shape (\*shape)
        Edge strength ``f`` of every pixel.
    exponent : float, optional
        Power of the distance with which the force of one charge decays; by default the dimension ``D``.

    Returns
    -------
    ndarray, shape (D, \*shape)
        Field, pointing towards the charges.

    Raises
    ------
    ValueError
        For an exponent that is not positive.
    """
    f = np.asarray(edge_map, dtype=float)
    power = float(f.ndim if exponent is None else exponent)
    if not power > 0:
        raise ValueError(f"exponent is {power:g} but must be above 0.")
    padded = tuple(scipy.fft.next_fast_len(2 * n - 1, real=True) for n in f.shape)
    axes = tuple(range(f.ndim))
    spectrum = scipy.fft.rfftn(-f, padded, axes=axes, workers=-1)
    inner = tuple(slice(0, n) for n in f.shape)
    out = np.empty((f.ndim, *f.shape))
    for axis, kernel in enumerate(_kernel_spectra(f.shape, padded, power)):
        out[axis] = scipy.fft.irfftn(spectrum * kernel, padded, axes=axes, workers=-1)[inner]
    return out


@lru_cache(maxsize=4)
def _kernel_spectra(
    shape: tuple[int, ...], padded: tuple[int, ...], power: float
) -> tuple[NDArray[np.complex128], ...]:
    """Fourier transforms of the field of one unit charge at the origin, one for each axis."""
    offsets = []
    for n, size in zip(shape, padded, strict=True):
        offset = np.arange(size, dtype=float)
        offset[offset >= n] -= size
        offset[np.abs(offset) >= n] = 0.0  # in the padding beyond any difference of two pixels: never read
        offsets.append(offset)
    grid = np.meshgrid(*offsets, indexing="ij", sparse=True)
    squared = sum((g**2 for g in grid[1:]), start=grid[0] ** 2)
    with np.errstate(divide="ignore"):
        decay = np.where(squared > 0, squared ** (-0.5 * (power + 1.0)), 0.0)
    axes = tuple(range(len(shape)))
    return tuple(scipy.fft.rfftn(g * decay, axes=axes, workers=-1) for g in grid)
