"""The electric field of eq. (8) and the potential of eq. (7), exact, by zero-padded convolutions.

Of a large image the field is computed in windows, where particles are (`WindowedField`).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property, lru_cache, partial, reduce
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike, DTypeLike, NDArray

from cpm_core.numerics.grids import Window, expand_window, relative_window, run_in_bands, window_shape
from cpm_core.numerics.parallel import count_cores, limit_blas
from cpm_core.numerics.real_numbers import check_finite_number
from cpm_core.numerics.types import Array, Index, Integers, Numbers, Single, record

_MAX_KEPT_PIXELS = 2**21
"""Pixels of an image up to which the spectra of its kernels are kept for the next image of the same size."""

_SPECTRUM_BLOCK = 2**14
"""Number of pixels whose spectrum, small enough for the cache, is multiplied with the kernels together."""

_MIN_SPECTRUM_COLUMNS = 8
"""Least number of columns of such a block."""

_MAX_DOUBLE_PIXELS = 2**22
"""Pixels up to which kernels are transformed in double precision."""


def convolved_field(
    edge_map: ArrayLike,
    exponent: float | None = None,
    precision: DTypeLike = np.float64,
    pitch: tuple[float, ...] | None = None,
) -> Numbers:
    r"""Compute the electric field of the fixed charges, exact to rounding, shape (D, \*shape).

    The sum of eq. (8) is a convolution; computed with Fourier transforms on a grid padded with zeros to at least twice
    the size, nothing wraps around. The field points towards the charges. `edge_map` is the edge strength ``f`` of every
    pixel, shape (\*shape); the force of one charge decays with the power `exponent` of the distance, by default the
    dimension ``D``. `pitch` has the distance of two pixels along each axis, by default one. In double precision the
    error is 1e-14 of the largest vector, in single precision 1e-6. Raises `ValueError` for an exponent that is not
    positive.
    """
    f = np.asarray(edge_map, dtype=precision)
    power = check_finite_number(
        "exponent", f.ndim if exponent is None else exponent, lambda number: number > 0.0, "above 0"
    )
    half = tuple(scipy.fft.next_fast_len(max(n, 2)) for n in f.shape)
    kernel_of = _kernel_spectrum if math.prod(half) <= _MAX_KEPT_PIXELS else _kernel_spectrum.__wrapped__
    # in single precision only where double takes too much memory
    made_in = np.dtype(float) if f.size <= _MAX_DOUBLE_PIXELS else f.dtype
    kernels = [kernel_of(k, half, power, made_in, f.dtype, pitch or (1.0,) * f.ndim) for k in range(f.ndim)]
    spectrum = scipy.fft.rfft(f, 2 * half[-1], workers=count_cores())
    fields = [*(np.empty_like(spectrum) for _ in half[1:]), spectrum]

    def convolve_columns(first: int, end: int) -> None:
        some = (..., slice(first, end))
        charges: NDArray[Any] = spectrum[some] * spectrum.dtype.type(1j)  # the kernels' spectra are imaginary
        for axis in reversed(range(f.ndim - 1)):  # axis by axis: rows of zeros are not transformed
            charges = scipy.fft.fft(charges, 2 * half[axis], axis, overwrite_x=True)
        for component, kernel in enumerate(kernels):
            back = _multiply_kernel(charges, kernel[some], component)
            for axis, n in enumerate(f.shape[:-1]):
                back = scipy.fft.ifft(back, axis=axis, overwrite_x=True)
                back = back[(slice(None),) * axis + (slice(n),)]
            fields[component][some] = back

    run_in_bands(
        convolve_columns, spectrum.shape[-1], max(_SPECTRUM_BLOCK // math.prod(half[:-1]), _MIN_SPECTRUM_COLUMNS)
    )
    kernels.clear()  # the rest needs their memory
    out = np.empty((f.ndim, *f.shape), f.dtype)
    for component in range(f.ndim):
        run_in_bands(partial(_transform_back, fields.pop(0), out[component]), len(f))
    return out


def _transform_back(spectrum: NDArray[Any], out: Array, first: int, end: int) -> None:
    """Transform the last axis of some planes back, without the padding."""
    out[first:end] = scipy.fft.irfft(spectrum[first:end])[..., : out.shape[-1]]


def _multiply_kernel(spectrum: NDArray[Any], kernel: Array, component: int) -> NDArray[Any]:
    """Multiply a spectrum by a component of the kernel, which is even along all axes except its own: there it is odd.

    The kernel has the frequencies from zero up to the largest one, along all axes.
    """
    product = np.empty_like(spectrum)
    for mirrored in np.ndindex((2,) * (spectrum.ndim - 1)):
        here = tuple(
            slice(n, None) if other else slice(n) for n, other in zip(kernel.shape[:-1], mirrored, strict=True)
        )
        there = tuple(slice(-2, 0, -1) if other else slice(None) for other in mirrored)
        np.multiply(spectrum[here], kernel[there], out=product[here])
        if component < len(mirrored) and mirrored[component]:
            np.negative(product[here], out=product[here])
    return product


@lru_cache(maxsize=12)
def _kernel_spectrum(
    component: int,
    half: Integers,
    power: float,
    made_in: np.dtype,
    precision: np.dtype,
    pitch: tuple[float, ...],
) -> Array:
    """Transform, over i, a component of the field of a unit charge at the origin: the transform is odd and real.

    The grid is twice `half` wide; the transform goes up to the largest frequency along each axis.
    """
    steps = [side * np.arange(n + 1.0, dtype=made_in) for n, side in zip(half, pitch, strict=True)]
    grid = np.meshgrid(*steps, indexing="ij", sparse=True)
    squared = reduce(np.add, [along**2 for along in grid])
    squared[(0,) * len(half)] = np.inf  # no charge acts on itself
    decay = _distance_power(squared, power)
    kernel = np.divide(grid[component], decay, out=decay)
    inner = (slice(None),) * component + (slice(1, -1),)
    for axis in range(len(half)):
        if axis == component:
            kernel[inner] = scipy.fft.dst(kernel[inner], 1, axis=axis, workers=count_cores())
            np.moveaxis(kernel, axis, 0)[-1] = 0.0
        else:
            kernel = scipy.fft.dct(kernel, 1, axis=axis, overwrite_x=True, workers=count_cores())
    return kernel.astype(precision, copy=False)


def _distance_power(squared: NDArray[Any], power: float) -> NDArray[Any]:
    """Return the power ``r^(n + 1)`` of distances by their squares; roots are several times faster than powers."""
    return squared * np.sqrt(squared) if power == 2.0 else squared ** (0.5 * (power + 1.0))


_NEAR_CHARGE_RANGE = 64
"""Distance up to which charges act one by one [px]."""

_NODE_SPACING = 8
"""Distance of the nodes that carry the rest of the field [px]."""

_POLYNOMIAL_TERMS = 4
"""Terms of the polynomial that replaces the law of force up to `_NEAR_CHARGE_RANGE`."""

_SINC_POWER = 8
"""Power of the sinc by which two cubic splines, to the nodes and between them, smooth their field."""

_NODES_BEYOND = 3
"""Nodes beyond the image on each side, over which its outermost charges are spread."""


@record
class WindowedField:
    """Electric field of the fixed charges of a large image in any window of it.

    Up to a distance of 64 px the sum of eq. (8) runs over charges, less a polynomial that joins the law of force there
    smoothly. The polynomial and all beyond it make a smooth field, which is computed once for the whole image, on nodes
    8 px apart: cubic splines spread the charges over them and run between them. The error is 1e-5 of the largest
    vector.

    Attributes
    ----------
    charges : ndarray, shape (H, W)
        Edge strength ``f`` of every pixel.
    exponent : float or None
        As for `convolved_field`.
    """

    charges: Array
    exponent: float | None

    @limit_blas()
    def field_in_window(self, window: Window) -> Single:
        r"""Compute the field in a window, shape (2, h, w)."""
        outer = expand_window(window, _NEAR_CHARGE_RANGE, self.charges.shape)
        sides = [n + 3 * _NEAR_CHARGE_RANGE for n in window_shape(window)]
        field = _convolve_charges(self.charges[outer], sides, _near_kernels, self.exponent)
        field = field[(slice(None), *relative_window(window, outer))]
        down, right = (
            slice(side.start // _NODE_SPACING, -(-side.stop // _NODE_SPACING) + 2 * _NODES_BEYOND) for side in window
        )
        rows, cols = (
            _node_weights(np.arange(side.start, side.stop), np.arange(some.start, some.stop) - _NODES_BEYOND)
            for side, some in zip(window, (down, right), strict=True)
        )
        field += rows @ self._nodes[:, down, right] @ cols.T
        return field

    @cached_property
    def _nodes(self) -> Single:
        """Smooth part of the field on the nodes, before the splines between them; shape (2, rows, columns)."""
        spread = np.empty(
            (len(self.charges), -(-self.charges.shape[1] // _NODE_SPACING) + 2 * _NODES_BEYOND), np.float32
        )

        def spread_rows(first: int, end: int) -> None:
            spread[first:end] = _spread_to_nodes(self.charges[first:end])

        run_in_bands(spread_rows, len(spread))
        charges = _spread_to_nodes(spread.T).T
        rows, cols = charges.shape
        return _convolve_charges(charges, [2 * rows, 2 * cols], _far_kernels, self.exponent)[:, :rows, :cols]


def _convolve_charges(
    charges: NDArray[np.floating],
    sides: list[int],
    kernels_of: Callable[[Integers, float], Single],
    exponent: float | None,
) -> Single:
    """Return the field of charges on a grid padded to these sides or more, by its two kernels, transformed over i."""
    padded = _fast_shape(sides)
    spectrum = scipy.fft.rfft2(charges.astype(np.float32, copy=False), padded, workers=count_cores()) * np.complex64(1j)
    spectrum = spectrum * kernels_of(padded, 2.0 if exponent is None else exponent)
    return np.asarray(scipy.fft.irfft2(spectrum, padded, workers=count_cores()))


def _fast_shape(sides: list[int]) -> Integers:
    """Return the least sides, from these on, whose transforms are fast; the last axis is transformed as real."""
    return tuple(scipy.fft.next_fast_len(n, axis == len(sides) - 1) for axis, n in enumerate(sides))


def _node_weights(pixels: Index, nodes: Index) -> Single:
    """Return weights of nodes in a cubic spline at pixels."""
    away = np.abs((pixels[:, None] + 0.5) / _NODE_SPACING - 0.5 - nodes)
    beyond, squared = np.maximum(2.0 - away, 0.0), away * away
    within = 2.0 / 3.0 - squared + 0.5 * away * squared
    return np.where(away < 1.0, within, beyond * beyond * beyond / 6.0).astype(np.float32)


def _spread_to_nodes(lines: NDArray[Any]) -> Single:
    """Spread charges along lines, shape (K, N), over nodes by a cubic spline each."""
    blocks = np.pad(lines, ((0, 0), (0, -lines.shape[1] % _NODE_SPACING))).reshape(len(lines), -1, _NODE_SPACING)
    weights = _node_weights(np.arange(_NODE_SPACING), np.arange(-2, 3))
    shares = blocks.astype(np.float32, copy=False) @ weights
    nodes = np.zeros((len(lines), blocks.shape[1] + 2 * _NODES_BEYOND), np.float32)
    for k in range(weights.shape[1]):
        nodes[:, k + 1 : k + 1 + blocks.shape[1]] += shares[..., k]
    return nodes


def _smooth_decay(squared: Single, power: float) -> Single:
    """Return the law of force over distance, ``1 / r^(n + 1)``, by the squared distance, smooth at short range."""
    decay, near = (
        np.reciprocal(_distance_power(np.maximum(squared, _NEAR_CHARGE_RANGE**2), power)),
        squared < _NEAR_CHARGE_RANGE**2,
    )
    inside, half, factor = np.zeros(np.count_nonzero(near)), 0.5 * (power + 1.0), 1.0
    for term in range(_POLYNOMIAL_TERMS):
        inside += factor * (squared[near] / _NEAR_CHARGE_RANGE**2 - 1.0) ** term
        factor *= -(half + term) / (term + 1)
    decay[near] = inside * _NEAR_CHARGE_RANGE ** (-2.0 * half)
    return decay


def _grid_offsets(padded: Integers, pitch: int) -> tuple[Single, Single]:
    """Return offsets between two nodes of a padded grid, shape (2, rows, columns) [px], and their squared length."""
    steps = (np.float32(pitch * size) * np.fft.fftfreq(size).astype(np.float32) for size in padded)
    offsets = np.stack(np.meshgrid(*steps, indexing="ij")).round()
    return offsets, offsets[0] ** 2 + offsets[1] ** 2


@lru_cache(maxsize=8)
def _near_kernels(padded: Integers, power: float) -> Single:
    """Transform, over i, the components of the field of one unit charge, less its smooth part."""
    offsets, squared = _grid_offsets(padded, 1)
    squared[0, 0] = _NEAR_CHARGE_RANGE**2  # no charge acts on itself
    decay = np.reciprocal(_distance_power(squared, power)) - _smooth_decay(squared, power)
    decay[squared >= _NEAR_CHARGE_RANGE**2] = 0.0
    return scipy.fft.rfft2(-decay * offsets, workers=count_cores()).imag.astype(np.float32)


@lru_cache(maxsize=8)
def _far_kernels(padded: Integers, power: float) -> Single:
    """Transform, over i, the smooth part on nodes, such that splines to and between them leave it as it is."""
    offsets, squared = _grid_offsets(padded, _NODE_SPACING)
    decay = _smooth_decay(squared, power)
    for axis, size in enumerate(padded):
        if size % 2 == 0:  # farther than any two nodes; without it the kernel is odd
            np.moveaxis(decay, axis, 0)[size // 2] = 0.0
    smoothing = (
        np.multiply.outer(np.sinc(np.fft.fftfreq(padded[0])), np.sinc(np.fft.rfftfreq(padded[1]))) ** _SINC_POWER
    )
    return (scipy.fft.rfft2(-decay * offsets, workers=count_cores()).imag / smoothing).astype(np.float32)


def convolved_potential(
    edge_map: NDArray[np.floating], pitch: tuple[float, ...] | None = None, exponent: float | None = None
) -> Array:
    r"""Compute the potential of the fixed charges of an image, shape (\*shape), whose slope is the field of eq. (8).

    ``V(r) = sum_k -f_k / ((n - 1) |r - R_k|^(n - 1))`` with the exponent ``n`` of the field, by default the dimension
    ``D``; in the plane this is eq. (7). For ``n = 1`` it is ``sum_k f_k log(|r - R_k| / R)``, where no two pixels are
    as far apart as ``R``. Below zero everywhere, and lowest on edges. No pixel acts on itself. `edge_map` is the edge
    strength ``f`` of every pixel [gray levels / px], of at least two axes, `pitch` the distance of two pixels along
    each, by default one. The transforms are done in single precision, with an error of 1e-6 of the largest value.
    """
    dimension, padded = edge_map.ndim, _fast_shape([2 * n - 1 for n in edge_map.shape])
    sides = (1.0,) * dimension if pitch is None else pitch
    steps = (side * (size * np.fft.fftfreq(size)) for size, side in zip(padded, sides, strict=True))
    offsets = np.meshgrid(*steps, indexing="ij", sparse=True)
    away = reduce(np.hypot, offsets).astype(np.float32)
    away[(0,) * dimension] = np.inf
    spectrum = scipy.fft.rfftn(edge_map.astype(np.float32), padded, workers=count_cores())
    power = (dimension if exponent is None else exponent) - 1.0
    if power == 0.0:
        away[(0,) * dimension] = away.max(where=np.isfinite(away), initial=1.0)
    depth = np.log(away.max() / away) if power == 0.0 else away**-power / power
    spectrum *= scipy.fft.rfftn(depth, workers=count_cores()).real  # it is even
    inner = tuple(slice(n) for n in edge_map.shape)
    potential: Array = scipy.fft.irfftn(spectrum, padded, workers=count_cores())[inner].astype(float)
    return -potential


def block_means(volume: Single, block: list[int]) -> Single:
    """Return the means of the blocks of a volume, shape (P, R, C); the last blocks may be smaller."""
    for axis, n in enumerate(block):
        if n > 1:
            starts = np.arange(0, volume.shape[axis], n)
            sums = np.add.reduceat(volume, starts, axis=axis)
            sums *= np.float32(1.0 / n)  # a smaller block counts as filled up with zeros
            volume = sums
    return volume
