"""The electric field of eq. (8) and the potential of eq. (7), exact, by zero-padded convolutions."""

from __future__ import annotations

import math
from functools import lru_cache, reduce
from typing import Any, TypeVar

import numpy as np
import scipy
from numpy.typing import ArrayLike, DTypeLike, NDArray

from cpm_core.numerics.parallel import cores
from cpm_core.numerics.real_numbers import checked_number
from cpm_core.numerics.types import Array, Single

_Grid = TypeVar("_Grid", Single, Array)

_MOST_KEPT = 2**23
"""Samples of a padded image up to which the spectra of its kernels are kept for the next image of the same size."""

_MOST_IN_DOUBLE = 2**22
"""Pixels up to which kernels are transformed in double precision."""


def convolved_field(
    edge_map: ArrayLike,
    exponent: float | None = None,
    precision: DTypeLike = np.float64,
    pitch: tuple[float, ...] | None = None,
) -> Array:
    r"""Electric field of the fixed charges, exact to rounding, shape (D, \*shape); it points towards the charges.

    The sum of eq. (8) is a convolution; computed with Fourier transforms on a grid padded with zeros to at least twice
    the size, nothing wraps around. `edge_map` is the edge strength ``f`` of every pixel, shape (\*shape); the force of
    one charge decays with the power `exponent` of the distance, by default the dimension ``D``. `pitch` has the
    distance of two pixels along each axis, by default one. In double precision the error is 1e-14 of the largest
    vector, in single precision 1e-6. Raises `ValueError` for an exponent that is not positive.
    """
    f = np.asarray(edge_map, dtype=precision)
    power = checked_number("exponent", f.ndim if exponent is None else exponent, lambda number: number > 0.0, "above 0")
    padded = tuple(scipy.fft.next_fast_len(2 * n, real=axis == f.ndim - 1) for axis, n in enumerate(f.shape))
    kept = math.prod(padded) <= _MOST_KEPT
    kernel_of = _kernel_spectrum if kept else _kernel_spectrum.__wrapped__
    # in single precision only where double takes too much memory
    made_in = np.dtype(float) if f.size <= _MOST_IN_DOUBLE else f.dtype
    spectrum = scipy.fft.rfft(f, padded[-1], workers=cores())
    for axis in reversed(range(f.ndim - 1)):  # axis by axis: rows of zeros are not transformed
        spectrum = scipy.fft.fft(spectrum, padded[axis], axis, overwrite_x=True, workers=cores())
    spectrum *= spectrum.dtype.type(1j)  # the kernels' spectra are imaginary
    out = np.empty((f.ndim, *f.shape), f.dtype)
    for component in range(f.ndim):
        back: NDArray[Any] = spectrum * kernel_of(component, padded, power, made_in, f.dtype, pitch or (1.0,) * f.ndim)
        for axis, n in enumerate(f.shape[:-1]):
            back = scipy.fft.ifft(back, axis=axis, overwrite_x=True, workers=cores())
            back = back[(slice(None),) * axis + (slice(n),)]
        out[component] = scipy.fft.irfft(back, padded[-1], workers=cores())[..., : f.shape[-1]]
    return out


@lru_cache(maxsize=12)
def _kernel_spectrum(
    component: int,
    padded: tuple[int, ...],
    power: float,
    made_in: np.dtype,
    precision: np.dtype,
    pitch: tuple[float, ...],
) -> Array:
    """Fourier transform, over i, of a component of the field of one unit charge at the origin: it is odd and real."""
    steps = [(side * (size * np.fft.fftfreq(size))).astype(made_in) for size, side in zip(padded, pitch, strict=True)]
    grid = np.meshgrid(*steps, indexing="ij", sparse=True)
    squared = reduce(np.add, [along**2 for along in grid])
    squared[(0,) * len(padded)] = np.inf  # no charge acts on itself
    # roots are several times faster than powers
    decay = squared * np.sqrt(squared) if power == 2.0 else squared ** (0.5 * (power + 1.0))
    kernel = -grid[component] / decay
    for axis, size in enumerate(padded):
        if size % 2 == 0:  # farther than any two pixels; without it the kernel is odd
            np.moveaxis(kernel, axis, 0)[size // 2] = 0.0
    return scipy.fft.rfftn(kernel, workers=cores()).imag.astype(precision)


def convolved_potential(
    edge_map: NDArray[np.floating], pitch: tuple[float, ...] | None = None, exponent: float | None = None
) -> Array:
    r"""Potential of the fixed charges of an image, shape (\*shape), whose slope is the field of eq. (8).

    ``V(r) = sum_k -f_k / ((n - 1) |r - R_k|^(n - 1))`` with the exponent ``n`` of the field, by default the dimension
    ``D``; in the plane this is eq. (7). For ``n = 1`` it is ``sum_k f_k log(|r - R_k| / R)``, where no two pixels are
    as far apart as ``R``. Below zero everywhere, and lowest on edges. No pixel acts on itself. `edge_map` is the edge
    strength ``f`` of every pixel [gray levels / px], of at least two axes, `pitch` the distance of two pixels along
    each, by default one. The transforms are done in single precision, with an error of 1e-6 of the largest value.
    """
    dimension, last = edge_map.ndim, edge_map.ndim - 1
    padded = tuple(scipy.fft.next_fast_len(2 * n - 1, axis == last) for axis, n in enumerate(edge_map.shape))
    sides = (1.0,) * dimension if pitch is None else pitch
    steps = (side * (size * np.fft.fftfreq(size)) for size, side in zip(padded, sides, strict=True))
    offsets = np.meshgrid(*steps, indexing="ij", sparse=True)
    away = reduce(np.hypot, offsets).astype(np.float32)
    away[(0,) * dimension] = np.inf
    spectrum = scipy.fft.rfftn(edge_map.astype(np.float32), padded, workers=cores())
    power = (dimension if exponent is None else exponent) - 1.0
    if power == 0.0:
        away[(0,) * dimension] = away.max(where=np.isfinite(away), initial=1.0)
    depth = np.log(away.max() / away) if power == 0.0 else away**-power / power
    spectrum *= scipy.fft.rfftn(depth, workers=cores()).real  # it is even
    inner = tuple(slice(n) for n in edge_map.shape)
    potential: Array = scipy.fft.irfftn(spectrum, padded, workers=cores())[inner].astype(float)
    return -potential


def block_means(volume: _Grid, block: list[int]) -> _Grid:
    """Means of the blocks of a volume, of so many voxels along each axis; the last blocks may be smaller."""
    for axis, n in enumerate(block):
        if n > 1:
            starts = np.arange(0, volume.shape[axis], n)
            sums = np.add.reduceat(volume, starts, axis=axis)
            sums *= np.float32(1.0 / n)  # a smaller block counts as filled up with zeros
            volume = sums
    return volume
