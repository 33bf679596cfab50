"""Scenes: an image, the boundary in it that is known exactly, and a start; and how images are painted from outlines."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy

from cpm_core.cli.figures.outlines import Rings, coverage
from cpm_core.contours.contour import Contour
from cpm_core.numerics.types import Array
from cpm_core.parameters import PRESETS, Parameters

Size = tuple[int, int]
Layer = tuple[Rings, float]
"""Outlines, and the gray levels by which what is inside them differs from what is outside."""


SHAPE = PRESETS["shape"]


@dataclass(frozen=True, eq=False)
class Scene:
    """What an experiment starts from.

    Attributes
    ----------
    values : ndarray, shape (H, W)
        Image.
    truth : tuple of Contour
        The boundary of the objects in it.
    seeds : ndarray, shape (N, 2)
        Where the particles start [px].
    parameters : Parameters
        Parameters of the run.
    """

    values: Array
    truth: tuple[Contour, ...]
    seeds: Array
    parameters: Parameters = SHAPE

    def started(self, seeds: Array) -> Scene:
        """The same with another start."""
        return replace(self, seeds=seeds)

    def under(self, parameters: Parameters) -> Scene:
        """The same with other parameters."""
        return replace(self, parameters=parameters)


def paint(size: Size, background: float, *layers: Layer) -> Array:
    """Gray levels of layers that lie beside or within one another, every pixel the mean over its area."""
    values = np.full(size, float(background))
    for outlines, contrast in layers:
        values += contrast * coverage(outlines, size)
    return values


def closed(*outlines: Rings) -> tuple[Contour, ...]:
    """Rings as the closed contours that a run ought to find."""
    return tuple(Contour(ring, closed=True) for rings in outlines for ring in rings)


def binary(size: Size, outlines: Rings, seeds: Array) -> Scene:
    """A bright shape on a dark ground."""
    return Scene(paint(size, 0.0, (outlines, 255.0)), closed(outlines), seeds)


def blurred(values: Array, sigma: float) -> Array:
    """An image out of focus by a Gaussian."""
    return np.asarray(scipy.ndimage.gaussian_filter(values, sigma, mode="nearest"))


def grain(size: Size, spread: float, seed: int) -> Array:
    """Normal noise of a standard deviation, each pixel for itself."""
    return np.random.default_rng(seed).normal(0.0, spread, size)


def texture(size: Size, grain_size: float | tuple[float, float], spread: float, seed: int) -> Array:
    """Cloudy texture: noise blurred by `grain_size` px (along rows and columns), of a standard deviation."""
    clouds = np.asarray(scipy.ndimage.gaussian_filter(grain(size, 1.0, seed), grain_size, mode="wrap"))
    return clouds * (spread / float(clouds.std()))
