"""Shapes that give particles in an area: evenly spread, or where edges are strong."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from cpm_core.model.starts import above
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Position
from cpm_core.shapes.path import ClosedPath, check_number

FINEST, COARSEST = 2.0, 64.0
"""Least and largest distance between two particles of a grid [px]."""

MOST_PLACES = 2**23
"""Particles that a grid may have; their places are counted before memory is taken for them."""

LOWEST, HIGHEST, STEP = 0.02, 0.98, 0.02
"""Bounds of the fraction of a threshold, and how much it changes at a time."""


@dataclass(frozen=True, slots=True)
class Grid(ClosedPath):
    """Particles spread evenly over an area.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) of the area in px of the image, at least three different ones.
    spacing : float
        Distance between particles along rows and columns [px].
    """

    title: ClassVar[str] = "grid"

    points: tuple[Position, ...]
    spacing: float = 8.0

    def __post_init__(self) -> None:
        ClosedPath.__post_init__(self)
        check_number("spacing", self.spacing)
        places = math.prod(length / self.spacing + 1.0 for length in _extent(self.points))
        if not places <= MOST_PLACES:
            raise ValueError(
                f"spacing is {self.spacing:g} px, which gives {places:.3g} particles in the box of the area, but there "
                f"may be {MOST_PLACES} at most: make the spacing wider or the area smaller."
            )

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 2), centered in the area; a single one where the area is too small."""
        low, high = np.min(self.points, axis=0), np.max(self.points, axis=0)
        along = [centered_along(length, self.spacing) for length in (high - low).tolist()]
        places = np.stack(np.meshgrid(*along, indexing="ij"), axis=-1).reshape(-1, 2) + low
        found = places[polyline.inside(self.points, places)]
        return np.asarray(found if len(found) else np.mean(self.points, axis=0)[None])

    def resized(self, by: float) -> Grid:
        """The same area with the spacing changed by so many px."""
        box = math.prod(length + 1.0 for length in _extent(self.points))
        finest = max(FINEST, math.ceil(math.sqrt(2.0 * box / MOST_PLACES)))
        return replace(self, spacing=min(max(self.spacing + by, finest), max(COARSEST, finest)))


@dataclass(frozen=True, slots=True)
class Threshold(ClosedPath):
    """Particles where edges are strong, in an area; their positions depend on the image.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) of the area in px of the image, at least three different ones.
    fraction : float
        Fraction of the largest edge strength in the area above which a pixel gets a particle.
    """

    title: ClassVar[str] = "threshold"
    follows_smoothing: ClassVar[bool] = True

    points: tuple[Position, ...]
    fraction: float = 0.3

    def __post_init__(self) -> None:
        ClosedPath.__post_init__(self)
        check_number("fraction", self.fraction, 0.0, 1.0)

    def seeds_for(self, values: Array, strength: Callable[[], Array]) -> Array:
        """Positions of the particles on an image, shape (N, 2); see `Everywhere.seeds_for`."""
        corner = np.array(values.shape) - 1
        low = np.clip(np.ceil(np.min(self.points, axis=0)), 0, corner).astype(int)
        high = np.clip(np.floor(np.max(self.points, axis=0)), 0, corner).astype(int)
        window = strength()[low[0] : high[0] + 1, low[1] : high[1] + 1]
        pixels = np.indices(window.shape).reshape(2, -1).T + low
        within = polyline.inside(self.points, pixels.astype(float)).reshape(window.shape)
        return above(np.where(within, window, 0.0), self.fraction) + low if within.any() else np.empty((0, 2))

    def resized(self, by: float) -> Threshold:
        """The same area with the threshold raised by so many steps of 0.02."""
        return replace(self, fraction=round(min(max(self.fraction + STEP * by, LOWEST), HIGHEST), 6))


def _extent(points: Sequence[Position]) -> list[float]:
    """Lengths of the box around points along rows and columns [px]."""
    return list(np.ptp(np.array(points, dtype=float), axis=0).tolist())


def centered_along(length: float, spacing: float) -> Array:
    """Positions along a length, with the same margin at both ends."""
    count = int(length // spacing) + 1
    return np.asarray(0.5 * length + spacing * (np.arange(count) - 0.5 * (count - 1)), dtype=float)
