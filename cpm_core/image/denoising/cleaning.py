"""Removal of heavy noise: the image without it, the smoothing that its edges then need, and the noise that remains.

Total variation finds the regions, but their boundaries follow the noise and small regions lose contrast. Averages of
the data along the edges that it has found have much less noise and keep the contrast; total variation of these averages
finds the edges again, more exactly. The length of the averages follows from the ratio of the noise to the edges: the
error of the position of a step grows with the square of this ratio and falls with the length of the average.

Where noise replaces pixels by random gray levels, the gray levels first go through a regression (`expected`). If that
reduces the noise much against the edges, the result is used in place of the data.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.image.denoising.histogram_regression import expected
from cpm_core.image.denoising.line_integral import averaged_along, directions
from cpm_core.image.denoising.total_variation import noise_level, total_variation
from cpm_core.numerics.types import Array

_FIRST, _FURTHER = 1.5, 1.0
"""Weight of the total variation of the data, and of averages along edges, in standard deviations of the noise."""

_ROUNDS = 3
"""Number of rounds: edges are found, and the data averaged along them."""

_SHORTEST, _LONGEST, _GROWTH = 4.0, 14.0, 0.8
"""Averages along edges: least and largest standard deviation [px], and power of noise over contrast between them."""

_COARSE = 8.0
"""With averages longer than this, all rounds but the last are done at half size, in an eighth of the time [px]."""

_REGRESSION_GAIN = 1.5
"""Factor by which the regression must reduce the noise against the edges to be used."""

_SHARPEST, _SLENDERNESS = 1.5, 0.21
"""Gaussian for the edges of the result: at least [px], and as a fraction of the length of the averages."""

_FINEST = 0.75
"""Least Gaussian before the directions of edges are computed [px]."""

_AGREEING = 0.9
"""Gaussian over which the directions of edges are averaged, as a fraction of the length of the averages."""

_PIXELS = 0.7
"""Gaussian that makes the pixels a smooth surface, for averages along any line [px]."""

_REMAINING, _LEAST_REMAINING, _MOST_REMAINING = 0.2, 0.12, 0.35
"""Steps that may remain of the noise: in its standard deviations, and least and largest fraction of the largest
step."""

_STEP = float(np.sqrt(2.0 * np.pi))
"""Height of a step over its slope, in widths of the Gaussian that smoothed it."""


class Cleaned(NamedTuple):
    """An image without heavy noise, and what its edges then need.

    Attributes
    ----------
    image : ndarray, shape (H, W)
        The image.
    sigma : float
        Gaussian by which to smooth it for its edges [px].
    floor : float
        Fraction of the largest edge strength up to which edges may be remains of noise.
    """

    image: Array
    sigma: float
    floor: float


def clean(values: Array) -> Cleaned:
    """Remove heavy noise from an image, shape (H, W).

    The result is flat between edges, which are in their place to within about a pixel, and rounded where they bend
    within the length of the averages.
    """
    seen = _estimate(values)
    length = float(np.clip(_SHORTEST * seen.ratio**_GROWTH, _SHORTEST, _LONGEST))
    if length < _COARSE:
        image = _regions(values, total_variation(values, _FIRST * seen.noise), seen.noise, length, _ROUNDS)
    else:
        regression = _estimate(expected(values, _doubled(seen.rough, values.shape)))
        if _REGRESSION_GAIN * regression.ratio < seen.ratio:
            seen = regression
        image = _regions(seen.halved, seen.rough, 0.5 * seen.noise, 0.5 * length, _ROUNDS - 1)
        image = _regions(seen.values, _doubled(image, values.shape), seen.noise, length, 1)
    width = max(_SHARPEST, _SLENDERNESS * length)
    step = _STEP * width * float(scipy.ndimage.gaussian_gradient_magnitude(image, width, mode="nearest").max())
    remaining = _REMAINING * seen.noise / step if step > 0.0 else 0.0
    return Cleaned(image, width, min(max(remaining, _LEAST_REMAINING), _MOST_REMAINING))


class _Estimate(NamedTuple):
    """First estimate: the image, it at half size, its noise, it without most of the noise, noise over contrast."""

    values: Array
    halved: Array
    noise: float
    rough: Array
    ratio: float


def _estimate(values: Array) -> _Estimate:
    """First estimate of an image, shape (H, W)."""
    halved = _halved(values)
    # halving the size halves white noise, but leaves more than half of correlated noise and of texture
    noise = max(2.0 * noise_level(halved), 4.0 * noise_level(_halved(halved)))
    rough = total_variation(halved, 0.5 * _FIRST * noise)
    contrast = _contrast(rough)
    return _Estimate(values, halved, noise, rough, noise / max(contrast, 1e-6 * noise, 1e-300))


def _regions(values: Array, image: Array, noise: float, length: float, rounds: int) -> Array:
    """Regions of an image, by averages along the edges of `image`, which is computed again in every round."""
    surface = scipy.ndimage.gaussian_filter(values, _PIXELS, mode="nearest")
    for _ in range(rounds):
        way = directions(image, max(_FINEST, _SLENDERNESS * length), _AGREEING * length)
        image = total_variation(averaged_along(surface, way, length), _FURTHER * noise)
    return image


def _contrast(image: Array) -> float:
    """Mean height of the steps in an image, with most weight on the high and the long ones [gray levels]."""
    width = 2.0
    slope = scipy.ndimage.gaussian_gradient_magnitude(image, width, mode="nearest")
    square = float((slope**2).sum())
    # across a smoothed step, cubes over squares of the slopes give sqrt(2/3) of the largest slope
    return _STEP * width * float(np.sqrt(1.5)) * float((slope**3).sum()) / square if square > 0.0 else 0.0


def _halved(values: Array) -> Array:
    """Image of half the size, from means of 2 x 2 pixels; the last row and column are repeated where one is missing."""
    rows, cols = values.shape
    even = np.pad(values, ((0, rows % 2), (0, cols % 2)), mode="edge")
    return np.asarray(even.reshape((rows + 1) // 2, 2, (cols + 1) // 2, 2).mean(axis=(1, 3)))


def _doubled(values: Array, shape: tuple[int, ...]) -> Array:
    """Image of a shape from the one of half the size."""
    row, col = (0.5 * (np.arange(size) - 0.5) for size in shape)
    grid = np.meshgrid(row, col, indexing="ij")
    return np.asarray(scipy.ndimage.map_coordinates(values, np.stack(grid), order=1, mode="nearest"))
