"""Heavy noise: what is left of an image without it, how finely that may be looked at, and what remains of the noise.

Total variation finds where there are regions, but lets their boundaries wobble with the noise and takes contrast from
small ones. Averages of the data along the edges that it has found are quieter by far, and have lost no contrast; total
variation of these finds the edges anew. How long the averages have to be tells the strength of the noise against the
edges: the error of a step's place grows with the square of their ratio and falls with the length of the average.

Where noise is heaviest, grey levels are asked first what they tell (`expected`). If that is much more than their height
does, as it is where noise has replaced pixels by others of any grey level, the data are taken for what they tell.
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
"""How often edges are found, and the data averaged along them."""

_SHORTEST, _LONGEST, _GROWTH = 4.0, 14.0, 0.8
"""Averages along edges: least and largest standard deviation [px], and power of noise over contrast between them."""

_COARSE = 8.0
"""With averages longer than this all rounds but the last are made at half size, in an eighth of the time [px]."""

_TELLING = 1.5
"""Factor by which noise has to lose against edges for grey levels to be taken for what they tell."""

_SHARPEST, _SLENDERNESS = 1.5, 0.21
"""Gaussian for the edges that are left: at least [px], and as a part of the length of the averages."""

_FINEST = 0.75
"""Gaussian before directions of edges are looked for, at least [px]."""

_AGREEING = 0.9
"""Gaussian over which directions of edges agree, as a part of the length of the averages."""

_PIXELS = 0.7
"""Gaussian that makes pixels a surface to be averaged along any line [px]."""

_REMAINING, _LEAST_REMAINING, _MOST_REMAINING = 0.2, 0.12, 0.35
"""Steps that may remain of noise, in its standard deviations, and in the largest step at least and at most."""

_STEP = float(np.sqrt(2.0 * np.pi))
"""Height of a step over its slope, in widths of the Gaussian it was smoothed with."""


class Cleaned(NamedTuple):
    """An image rid of what noise it had to be rid of, and what it then needs.

    Attributes
    ----------
    image : ndarray, shape (H, W)
        What is left.
    sigma : float
        Gaussian by which to smooth it for its edges [px].
    floor : float
        Fraction of the largest edge strength up to which edges may be remains of noise.
    """

    image: Array
    sigma: float
    floor: float


def clean(values: Array) -> Cleaned:
    """Take heavy noise out of an image.

    Parameters
    ----------
    values : ndarray, shape (H, W)
        Image.

    Returns
    -------
    Cleaned
        The image, flat between edges that are in their place to within a pixel or so, rounded where they bend within
        the length that the noise makes necessary.
    """
    seen = _look(values)
    length = float(np.clip(_SHORTEST * seen.ratio**_GROWTH, _SHORTEST, _LONGEST))
    if length < _COARSE:
        image = _regions(values, total_variation(values, _FIRST * seen.noise), seen.noise, length, _ROUNDS)
    else:
        told = _look(expected(values, _doubled(seen.rough, values.shape)))
        if _TELLING * told.ratio < seen.ratio:
            seen = told
        image = _regions(seen.halved, seen.rough, 0.5 * seen.noise, 0.5 * length, _ROUNDS - 1)
        image = _regions(seen.values, _doubled(image, values.shape), seen.noise, length, 1)
    width = max(_SHARPEST, _SLENDERNESS * length)
    step = _STEP * width * float(scipy.ndimage.gaussian_gradient_magnitude(image, width, mode="nearest").max())
    remaining = _REMAINING * seen.noise / step if step > 0.0 else 0.0
    return Cleaned(image, width, min(max(remaining, _LEAST_REMAINING), _MOST_REMAINING))


class _Look(NamedTuple):
    """A first look at an image: it, half its size, its noise, that without most of the noise, noise over contrast."""

    values: Array
    halved: Array
    noise: float
    rough: Array
    ratio: float


def _look(values: Array) -> _Look:
    """Take a first look at an image."""
    halved = _halved(values)
    # halving halves white noise, and leaves more than half of noise that has a grain, or of texture
    noise = max(2.0 * noise_level(halved), 4.0 * noise_level(_halved(halved)))
    rough = total_variation(halved, 0.5 * _FIRST * noise)
    contrast = _contrast(rough)
    return _Look(values, halved, noise, rough, noise / max(contrast, 1e-6 * noise, 1e-300))


def _regions(values: Array, image: Array, noise: float, length: float, rounds: int) -> Array:
    """Regions of an image by averages along the edges of `image`, which is made anew with every round."""
    surface = np.asarray(scipy.ndimage.gaussian_filter(values, _PIXELS, mode="nearest"))
    for _ in range(rounds):
        way = directions(image, max(_FINEST, _SLENDERNESS * length), _AGREEING * length)
        image = total_variation(averaged_along(surface, way, length), _FURTHER * noise)
    return image


def _contrast(image: Array) -> float:
    """Height of the steps in an image, the high and the long ones above all [gray levels]."""
    width = 2.0
    slope = scipy.ndimage.gaussian_gradient_magnitude(image, width, mode="nearest")
    square = float((slope**2).sum())
    # across a smoothed step the cubes of its slopes are to their squares as sqrt(2/3) of the largest slope
    return _STEP * width * float(np.sqrt(1.5)) * float((slope**3).sum()) / square if square > 0.0 else 0.0


def _halved(values: Array) -> Array:
    """Image of half the size, of the means of 2 x 2 pixels; the last row and column are repeated where one is short."""
    rows, cols = values.shape
    even = np.pad(values, ((0, rows % 2), (0, cols % 2)), mode="edge")
    return np.asarray(even.reshape((rows + 1) // 2, 2, (cols + 1) // 2, 2).mean(axis=(1, 3)))


def _doubled(values: Array, shape: tuple[int, ...]) -> Array:
    """Image of a shape whose halved one is given."""
    row, col = (0.5 * (np.arange(size) - 0.5) for size in shape)
    grid = np.meshgrid(row, col, indexing="ij")
    return np.asarray(scipy.ndimage.map_coordinates(values, np.stack(grid), order=1, mode="nearest"))
