"""Shapes that give particles in an area: evenly spread, or where edges are strong."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar, Self

import numpy as np

from cpm_core.image.image import Image
from cpm_core.model.starts import pixels_above
from cpm_core.numerics import polyline
from cpm_core.numerics.grids import grid_points
from cpm_core.numerics.types import Array, Mask, frozen
from cpm_core.shapes.path import ClosedPath, check_number

MIN_GRID_SPACING = 2.0
"""Least distance between two particles of a grid [px]."""

LARGEST_GRID_SPACING = 64.0
"""Largest distance between two particles of a grid [px]."""

MAX_GRID_PARTICLES = 2**23
"""Largest number of particles of a grid; they are counted before memory is taken for them."""

MIN_THRESHOLD_FRACTION = 0.02
"""Least fraction of a threshold."""

LARGEST_THRESHOLD_FRACTION = 0.98
"""Largest fraction of a threshold."""

THRESHOLD_FRACTION_STEP = 0.02
"""Change of the fraction of a threshold at a time."""


@frozen
class Spaced:
    """Evenly filled shape; its size is the distance of the particles. The shape itself is the other base."""

    title: ClassVar[str] = "grid"

    spacing: float = 8.0

    def __post_init__(self) -> None:
        super().__post_init__()  # type: ignore[misc]
        check_spacing(self.spacing, self._lengths)

    @property
    def _lengths(self) -> list[float]:
        raise NotImplementedError

    def resized_by(self, amount: float) -> Self:
        """Return the shape with its spacing changed, within the allowed density of particles."""
        finest = max(MIN_GRID_SPACING, finest_spacing(self._lengths))
        spacing = min(max(self.spacing + amount, finest), max(LARGEST_GRID_SPACING, finest))
        return replace(self, spacing=spacing)


@frozen
class OnStrongEdges:
    """Shape with particles where edges are strong; its size is how strong. The shape itself is the other base."""

    follows_smoothing: ClassVar[bool] = True
    title: ClassVar[str] = "threshold"

    fraction: float = 0.3

    def __post_init__(self) -> None:
        super().__post_init__()  # type: ignore[misc]
        check_number("fraction", self.fraction, 0.0, 1.0)

    def resized_by(self, steps: float) -> Self:
        """Return the shape with its threshold raised by a number of steps of 0.02."""
        fraction = round(
            min(
                max(self.fraction + THRESHOLD_FRACTION_STEP * steps, MIN_THRESHOLD_FRACTION),
                LARGEST_THRESHOLD_FRACTION,
            ),
            6,
        )
        return replace(self, fraction=fraction)


@frozen
class Grid(Spaced, ClosedPath):
    """Particles spread evenly over an area.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) of the area in px of the image, at least three different ones.
    spacing : float
        Distance between particles along rows and columns [px].
    """

    def seeds(self) -> Array:
        """Return the positions of the particles, shape (N, 2), centered in the area; at least one."""
        places = place_evenly(self._lengths, self.spacing) + np.min(self.points, axis=0)
        found = places[polyline.points_inside(self.points, places)]
        return found if len(found) else np.mean(self.points, axis=0)[None]

    @property
    def _lengths(self) -> list[float]:
        """Lengths of the box around the area along rows and columns [px]."""
        return list(np.ptp(np.array(self.points, float), axis=0).tolist())


@frozen
class Threshold(OnStrongEdges, ClosedPath):
    """Particles where edges are strong, in an area; their positions depend on the image.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) of the area in px of the image, at least three different ones.
    fraction : float
        Fraction of the largest edge strength in the area above which a pixel gets a particle.
    """

    def seeds_on(self, _image: Image, _channel: str, find_strength: Callable[[], Array]) -> Array:
        """Return the positions of the particles on an image, shape (N, 2); see `Everywhere.seeds_on`."""
        return find_strong_pixels(
            find_strength(), self.outline, self.fraction, lambda places: polyline.points_inside(self.points, places)
        )


def find_strong_pixels(
    strength: Array, outline: Array, fraction: float, contains: Callable[[Array], Mask] | None = None
) -> Array:
    """Find the pixels in the box of an outline, shape (K, D), with an edge strength above a fraction of the largest.

    Only places, shape (N, D), that an area `contains` count; by default all. Returns shape (M, D).
    """
    low = np.clip(np.ceil(outline.min(axis=0)), 0, strength.shape).astype(int)
    high = np.clip(np.floor(outline.max(axis=0)) + 1, low, strength.shape).astype(int)
    window = strength[tuple(map(slice, low, high))]
    if contains is not None:
        places = np.indices(window.shape).reshape(window.ndim, -1).T + low
        window = np.where(contains(places.astype(float)).reshape(window.shape), window, 0.0)
    return pixels_above(window, fraction) + low if window.size else np.empty((0, window.ndim))


def check_spacing(spacing: float, lengths: Sequence[float]) -> None:
    """Check that a grid in a box of these lengths has no more particles than are allowed, else raise ValueError."""
    check_number("spacing", spacing)
    places = math.prod(length / spacing + 1.0 for length in lengths)
    if not places <= MAX_GRID_PARTICLES:
        raise ValueError(
            f"spacing is {spacing:g}, which gives {places:.3g} particles in the box around the grid, but there may be "
            f"{MAX_GRID_PARTICLES} at most: make the spacing wider or the box smaller."
        )


def finest_spacing(lengths: Sequence[float]) -> int:
    """Return the least spacing at which a box of these lengths has no more particles than allowed."""
    side = (2.0 * math.prod(length + 1.0 for length in lengths) / MAX_GRID_PARTICLES) ** (1.0 / len(lengths))
    return math.ceil(side)


def place_evenly(lengths: Sequence[float], spacing: float) -> Array:
    """Place positions evenly in a box of D lengths, shape (N, D), with the same margin on opposite sides."""
    along = []
    for length in lengths:
        count = int(length // spacing) + 1
        along.append(0.5 * length + spacing * (np.arange(count) - 0.5 * (count - 1)))
    return grid_points(along)
