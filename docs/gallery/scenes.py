"""Scenes: a synthetic image, its exact boundaries, seeds and parameters; and painting of images from outlines."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from cpm_core.contours.contour import Contour
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from docs.gallery.outlines import Rings, coverage

Size = tuple[int, int]
Layer = tuple[Rings, float]
"""Outlines, and the difference of gray levels between their inside and outside."""

SHAPE = Parameters()
"""The parameters of the publication, whose runs find all that is connected to a start."""


@dataclass(frozen=True, eq=False)
class Scene:
    """Input of an experiment: image (H, W), true boundaries, seeds (N, 2) [px] and parameters."""

    values: Array
    truth: tuple[Contour, ...]
    seeds: Array
    parameters: Parameters = SHAPE

    def under(self, parameters: Parameters) -> Scene:
        """Return the same scene with other parameters."""
        return replace(self, parameters=parameters)


def paint(size: Size, background: float, *layers: Layer) -> Array:
    """Gray levels of layers beside or within one another, every pixel the mean over its area."""
    values = np.full(size, float(background))
    for outlines, contrast in layers:
        values += contrast * coverage(outlines, size)
    return values


def closed(*outlines: Rings) -> tuple[Contour, ...]:
    """Rings as closed contours of the truth."""
    return tuple(Contour(ring, closed=True) for rings in outlines for ring in rings)


def binary(size: Size, outlines: Rings, seeds: Array) -> Scene:
    """Paint a bright shape on a dark background."""
    return Scene(paint(size, 0.0, (outlines, 255.0)), closed(outlines), seeds)


def blurred(values: Array, sigma: float) -> Array:
    """Smooth an image by a Gaussian, as if out of focus."""
    return np.asarray(scipy.ndimage.gaussian_filter(values, sigma, mode="nearest"))


def grain(size: Size, spread: float, seed: int) -> Array:
    """Uncorrelated normal noise of a standard deviation `spread`."""
    return np.random.default_rng(seed).normal(0.0, spread, size)


def texture(size: Size, grain_size: float | tuple[float, float], spread: float, seed: int) -> Array:
    """Texture: noise smoothed by `grain_size` px (along rows and columns), of a standard deviation `spread`."""
    clouds = np.asarray(scipy.ndimage.gaussian_filter(grain(size, 1.0, seed), grain_size, mode="wrap"))
    return clouds * (spread / float(clouds.std()))
