"""The edge map: strength with which each pixel attracts the particles.

Every pixel carries a fixed charge ``-f`` with ``f = |grad(G_sigma * I)|`` (section 3.1).
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import scipy
from numpy.typing import ArrayLike, DTypeLike, NDArray

from cpm_core.image.denoising import DenoisedImage, noise_level, remove_noise
from cpm_core.numerics.grids import Window, expand_window, gaussian_radius, relative_window, run_in_bands, smooth_rows
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import run_in_parallel
from cpm_core.numerics.real_numbers import as_real_array, check_finite_number, check_image_values
from cpm_core.numerics.types import Array, Index, Mask, Numbers, Single
from cpm_core.numerics.vectors import Vector

_BACKGROUND_DEVIATIONS = 4.0
"""Deviations of a component of the gradient that the background rarely exceeds."""

_RAYLEIGH_QUARTILE = 0.7585276164
"""Lower quartile of the Rayleigh distribution of unit width, ``sqrt(2 ln(4/3))``."""

_SMOOTHING_SERIES = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
"""Widths that the automatic smoothing tries [px]."""

_HEAVY_NOISE_SIGMA = 2.0
"""Gaussian beyond which noise counts as heavy [px]."""

_FAINT_NOISE = 0.05
"""Noise, as a fraction of the standard deviation of the gray levels, that does not explain the background."""

_STRONG_GRADIENT_PERCENTILE = 99.0
"""Percentile of the edge strength that counts as strong."""


_WEAK_BACKGROUND = 0.25
"""Fraction of the strong edges under which the background is weak enough."""

NO_SMOOTHING = 0.01
"""Standard deviation up to which a Gaussian has no weight next to its pixel in double precision [px]."""

_SLAB_PLANES = 8
"""Number of planes of a volume that are processed together."""

_MIN_DIFFERENCE_PIXELS = 2
"""Number of pixels along an axis needed for a difference of two."""


def smoothed_gradient(values: ArrayLike, smoothing: float, precision: DTypeLike = np.float64) -> Array:
    r"""Return the gradient of the smoothed image, shape (D, \*shape) [gray levels / px].

    Central differences of `values`, shape (\*shape), after a Gaussian of standard deviation `smoothing` [px]; 0 leaves
    the image as it is. The image is continued beyond its border by its outermost pixels, so that the border is no edge.
    `precision` is the type of the result.
    """
    image = as_real_array(values)
    out = np.empty((image.ndim, *image.shape), precision)
    if image.ndim == 2 and smoothing > NO_SMOOTHING:
        image = np.ascontiguousarray(image)

        def write_band(first: int, end: int) -> None:
            smooth, at = smooth_rows(image, smoothing, first - 1, end + 1), min(first, 1)
            slopes = _central_differences(smooth, np.empty((2, *smooth.shape), out.dtype))
            out[:, first:end] = slopes[:, at : at + end - first]

        run_in_bands(write_band, len(image))
        return out
    if smoothing > NO_SMOOTHING:
        image = scipy.ndimage.gaussian_filter(image, smoothing, mode="nearest")
    return _central_differences(image, out)


def gradient_in_window(values: Array, smoothing: float, window: Window) -> Array:
    """Return `smoothed_gradient` of an image, shape (H, W), in a window of it, shape (2, h, w), in single precision."""
    outer = expand_window(window, gaussian_radius(smoothing) + 1, values.shape)
    return smoothed_gradient(values[outer], smoothing, np.float32)[(slice(None), *relative_window(window, outer))]


def _central_differences(values: NDArray[np.floating], out: Numbers) -> Numbers:
    r"""Write the central differences of values, shape (\*shape), along each axis, and of two values at the border."""
    for axis, part in enumerate(out):
        line, slope = np.moveaxis(values, axis, 0), np.moveaxis(part, axis, 0)
        np.subtract(line[2:], line[:-2], out=slope[1:-1])
        np.subtract(line[1:2], line[:1], out=slope[:1])
        np.subtract(line[-1:], line[-2:-1], out=slope[-1:])
    out *= out.dtype.type(0.5)
    return out


def vector_magnitudes(vectors: NDArray[np.floating]) -> Array:
    r"""Return the length of each vector of a field, shape (D, \*shape), as shape (\*shape)."""
    return np.sqrt(np.einsum("i...,i...->...", vectors, vectors))


def volume_edge_map(smoothed: Single, pitch: Vector, inside: Mask | None = None) -> Single:
    """Return the edge map of a smoothed volume, shape (P, R, C), with voxels of these sides [gray levels / unit].

    Outside `inside` it is zero.
    """
    out = np.empty(smoothed.shape, np.float32)
    sides = np.array(pitch, np.float32).reshape(3, 1, 1, 1)

    def write_planes(first: int, end: int) -> None:
        slab, at = smoothed[max(first - 1, 0) : end + 1], min(first, 1)
        slopes = _central_differences(slab, np.empty((3, *slab.shape), np.float32)) / sides
        out[first:end] = vector_magnitudes(slopes)[at : at + end - first]

    run_in_bands(write_planes, len(out), _SLAB_PLANES)
    if inside is not None:
        out *= inside
    return out


def edge_map(values: ArrayLike, smoothing: float | Literal["auto"] = 1.0) -> Array:
    r"""Compute the edge map ``f = |grad(G_sigma * I)|`` of an image (section 3.1).

    Parameters
    ----------
    values : array_like, shape (\*shape)
        Image.
    smoothing : float or "auto"
        Standard deviation of the Gaussian [px], or ``"auto"`` to choose it by the noise of the image.

    Returns
    -------
    ndarray, shape (\*shape)
        Edge strength [gray levels / px]; the fixed charge is its negative.

    Raises
    ------
    ValueError
        When the values are no image of finite numbers, or the smoothing is no number from 0 on.

    Examples
    --------
    >>> strength = cpm.edge_map(cpm.example("disk").values, smoothing=1.0)
    >>> strength.shape, bool(strength[32, 12] > 10 * strength[32, 32])
    ((64, 64), True)
    """
    image = check_image_values(values, _MIN_DIFFERENCE_PIXELS)
    if isinstance(smoothing, str) and smoothing == "auto":
        image, smoothing, _ = prepare_for_edges(image)
    return vector_magnitudes(
        smoothed_gradient(image, check_finite_number("smoothing", smoothing, lambda sigma: sigma >= 0.0, "0 or more"))
    )


def background_strength(strength: Array) -> float:
    r"""Return the edge strength that the background rarely exceeds [gray levels / px]; 0 for a flat background.

    In the background noise and texture give a gradient with normally distributed components, so that its magnitude
    follows a Rayleigh distribution. Where edges cover less than about half of an image, the lower quartile of the edge
    map, shape (\*shape), gives its width. The result is four standard deviations of a component, which one in three
    thousand pixels exceeds by chance.
    """
    return _BACKGROUND_DEVIATIONS * _lower_quartile(strength.ravel()) / _RAYLEIGH_QUARTILE


_SORTING_BITS = 16
"""Number of leading bits by which numbers are sorted roughly."""

_NUMBERS_PER_THREAD = 2**20
"""Numbers from which a second thread counts them faster."""


def _lower_quartile(values: Array) -> float:
    """Return the lower quartile of numbers that are not negative, shape (N,), without a copy of all of them.

    The bits of such numbers have the order of the numbers.
    """
    bits = values.view(f"i{values.itemsize}")
    shift = 8 * values.itemsize - _SORTING_BITS
    counts: list[Index] = []

    def count_some(first: int, end: int) -> None:
        own = np.zeros(1 << _SORTING_BITS, np.int64)
        _count_leading_bits(bits[first:end], shift, own)
        counts.append(own)

    run_in_parallel(count_some, len(bits), _NUMBERS_PER_THREAD)
    before = np.cumsum(sum(counts))
    place = 0.25 * (len(values) - 1)
    first, last = np.searchsorted(before, [int(place), math.ceil(place)], side="right").tolist()
    some = np.sort(values[(bits >= first << shift) & (bits < last + 1 << shift)])
    place -= before[first - 1] if first else 0
    return float(np.interp(place, np.arange(len(some)), some))


@compiled
def _count_leading_bits(bits: Index, shift: int, counts: Index) -> None:
    """Count the numbers that begin with the same bits."""
    for number in bits:
        counts[number >> shift] += 1


def prepare_for_edges(values: Array) -> DenoisedImage:
    """Prepare a noisy image for its edges: the image to smooth, its sigma, and the noise that remains.

    Light noise is left to a Gaussian, and the image is returned as it is, with a floor of 0. Where the Gaussian would
    have to be wide, total variation and averages along edges (`remove_noise`) first remove the noise and keep the
    position of edges. Volumes, shape (P, H, W), are left to the Gaussian: the averages along edges exist in the plane
    only.
    """
    sigma = automatic_smoothing(values)
    if values.ndim != 2 or sigma <= _HEAVY_NOISE_SIGMA or noise_level(values) <= _FAINT_NOISE * float(values.std()):
        return DenoisedImage(values, sigma, 0.0)
    return remove_noise(values)


def automatic_smoothing(values: ArrayLike) -> float:
    r"""Return the least sigma [px] that raises the edges of a noisy image, shape (\*shape), above its background.

    With it `background_strength` is below a quarter of the strong edges; where no sigma of the series reaches this, the
    one that comes closest.
    """
    image = as_real_array(values)
    shares = []
    for sigma in _SMOOTHING_SERIES:
        strength = vector_magnitudes(smoothed_gradient(image, sigma))
        strong = float(np.percentile(strength, _STRONG_GRADIENT_PERCENTILE))
        shares.append(background_strength(strength) / strong if strong > 0.0 else 0.0)
        if shares[-1] <= _WEAK_BACKGROUND:
            return sigma
    return _SMOOTHING_SERIES[int(np.argmin(shares))]
