"""The electric field of eq. (8) and the potential of eq. (7), exact, by zero-padded convolutions.

The transforms of the field are done axis by axis: rows of zeros are not transformed forward, and what is cut off is not
transformed back. It takes about as long as the three plain transforms that it consists of.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from functools import reduce
from itertools import product
from threading import Lock

import numpy as np
import scipy
from numpy.typing import ArrayLike, DTypeLike, NDArray

from cpm_core.numerics.parallel import cores
from cpm_core.numerics.real_numbers import checked_number
from cpm_core.numerics.types import Array

_KEPT_BYTES = 128 * 2**20
"""Memory for kernel spectra that are kept for the next image of the same size: enough for the three scales of one of
2048 x 2048 pixels in double precision (93 MB). Larger spectra are computed each time [bytes]."""


_WHOLE = 2**24
"""Samples of a padded image that are transformed as a whole."""

_BLOCK = 2**22
"""Samples that are transformed at once of a larger one, so that padded copies stay small."""

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
    given = f.ndim if exponent is None else exponent
    power = checked_number("exponent", given, lambda number: number > 0.0, "above 0")
    # the kernel's mirror image begins at half of an even size, which must exceed all differences of two pixels
    padded = tuple(2 * scipy.fft.next_fast_len(max(n, 2), real=axis == f.ndim - 1) for axis, n in enumerate(f.shape))
    spectrum = scipy.fft.rfft(f, padded[-1], axis=-1, workers=cores())
    kernels = _spectra.of(f.shape, padded, power, f.dtype, pitch)
    out = np.empty((f.ndim, *f.shape), f.dtype)
    if math.prod(padded[:-1]) * spectrum.shape[-1] <= _WHOLE:
        for component, part in enumerate(_convolved(spectrum, kernels, f.shape, padded)):
            out[component] = scipy.fft.irfft(part, padded[-1], axis=-1, workers=cores())[..., : f.shape[-1]]
        return out
    parts = [*(np.empty_like(spectrum) for _ in kernels[1:]), spectrum]
    step = max(_BLOCK // math.prod(padded[:-1]), 1)
    for first in range(0, spectrum.shape[-1], step):
        some = (..., slice(first, first + step))
        convolved = _convolved(spectrum[some].copy(), [kernel[some] for kernel in kernels], f.shape, padded)
        for part, back in zip(parts, convolved, strict=True):
            part[some] = back
    lines = max(_BLOCK // math.prod(f.shape[1:-1]) // padded[-1], 1) if f.ndim > 1 else len(spectrum)
    for component, part in enumerate(parts):
        for first in range(0, len(spectrum), lines):
            rows = slice(first, first + lines)
            out[component, rows] = scipy.fft.irfft(part[rows], padded[-1], axis=-1, workers=cores())[..., : f.shape[-1]]
    return out


def _convolved(
    whole: NDArray[np.complexfloating], kernels: Sequence[Array], shape: tuple[int, ...], padded: tuple[int, ...]
) -> Iterator[NDArray[np.complexfloating]]:
    """Convolve some frequencies of the last axis with each kernel along the other axes, and cut off the padding.

    `whole` is overwritten; a result holds until the next one is asked for.
    """
    for axis in reversed(range(whole.ndim - 1)):
        whole = scipy.fft.fft(whole, padded[axis], axis=axis, overwrite_x=True, workers=cores())
    whole *= whole.dtype.type(1j)  # the kernels' spectra are imaginary
    multiplied = np.empty_like(whole)
    for component, kernel in enumerate(kernels):
        _multiply(whole, kernel, component, multiplied)
        back = multiplied
        for axis, n in enumerate(shape[:-1]):
            back = scipy.fft.ifft(back, axis=axis, overwrite_x=True, workers=cores())
            back = back[(slice(None),) * axis + (slice(n),)]
        yield back


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


def _multiply(
    spectrum: NDArray[np.complexfloating], kernel: Array, component: int, out: NDArray[np.complexfloating]
) -> None:
    """Multiply a spectrum by a kernel at the frequencies that are not negative: odd along `component`, else even."""
    last = spectrum.ndim - 1
    for mirrored in product((False, True), repeat=last):
        half = [
            slice(kernel.shape[axis], None) if back else slice(kernel.shape[axis]) for axis, back in enumerate(mirrored)
        ]
        source = tuple(slice(-2, 0, -1) if back else slice(None) for back in mirrored)
        odd = component < last and mirrored[component]
        np.multiply(spectrum[tuple(half)], -kernel[source] if odd else kernel[source], out=out[tuple(half)])


class _Spectra:
    """Fourier transforms of the field of one unit charge at the origin, the last ones used kept in bounded memory."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[object, ...], tuple[Array, ...]] = OrderedDict()
        self._lock = Lock()

    def of(
        self,
        shape: tuple[int, ...],
        padded: tuple[int, ...],
        power: float,
        precision: np.dtype,
        pitch: tuple[float, ...] | None,
    ) -> tuple[Array, ...]:
        """Spectra for each component; see `_kernel_spectra`."""
        key = (shape, padded, power, precision, pitch)
        with self._lock:
            if key in self._kept:
                self._kept.move_to_end(key)
                return self._kept[key]
        spectra = tuple(_kernel_spectra(shape, padded, power, precision, pitch))
        with self._lock:
            self._kept[key] = spectra
            while self.size > _KEPT_BYTES:
                self._kept.popitem(last=False)
        return spectra

    @property
    def size(self) -> int:
        """Memory that the kept spectra take up [bytes]."""
        return sum(kernel.nbytes for spectra in self._kept.values() for kernel in spectra)


_spectra = _Spectra()


def _kernel_spectra(
    shape: tuple[int, ...],
    padded: tuple[int, ...],
    power: float,
    precision: np.dtype,
    pitch: tuple[float, ...] | None,
) -> Iterator[Array]:
    """Imaginary parts, but for the sign, of the kernels' spectra at frequencies that are not negative.

    The field of one charge is odd along its own component and even along the others, so that sine and cosine transforms
    of a quarter (an eighth) of the grid give its whole spectrum, which has no real part.
    """
    # in single precision only where double takes too much memory
    most = np.dtype(float) if math.prod(shape) <= _MOST_IN_DOUBLE else precision
    sides = (1.0,) * len(shape) if pitch is None else pitch
    steps = (np.arange(size // 2 + 1, dtype=most) * most.type(side) for size, side in zip(padded, sides, strict=True))
    grid = np.meshgrid(*steps, indexing="ij", sparse=True)
    squared = sum((g**2 for g in grid[1:]), start=grid[0] ** 2)
    squared[(0,) * len(shape)] = np.inf  # no charge acts on itself
    # a root is several times faster than a power
    if power == 2.0:
        decay = 1.0 / (squared * np.sqrt(squared))
    else:
        decay = 1.0 / (squared * squared) if power == 3.0 else squared ** (-0.5 * (power + 1.0))
    for axis, n in enumerate(shape):  # beyond any difference of two pixels: never read
        decay[(slice(None),) * axis + (slice(n, None),)] = 0.0
    del squared
    for component, offset in enumerate(grid):
        kernel = offset * decay
        for axis in range(len(shape)):
            if axis == component:
                inner = (slice(None),) * axis + (slice(1, -1),)
                kernel[inner] = scipy.fft.dst(kernel[inner], type=1, axis=axis, workers=cores())
                kernel[(slice(None),) * axis + ([0, -1],)] = 0.0
            else:
                kernel = scipy.fft.dct(kernel, type=1, axis=axis, overwrite_x=True, workers=cores())
        yield kernel.astype(precision, copy=False)
