"""The shapes that a user draws: circles and points, each of which gives particles to start from."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core import initialization

Position = tuple[float, float]

SMALLEST_RADIUS = 1.0
"""Radius under which a drawn circle is taken for a slip of the hand [px]."""


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle of particles.

    Attributes
    ----------
    center : tuple of float
        (row, col) in px of the image.
    radius : float
        Radius [px], above zero.
    """

    center: Position
    radius: float

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return initialization.circle(self.center, self.radius)

    def moved(self, by: Position) -> Circle:
        """The same circle displaced by (rows, cols)."""
        return Circle((self.center[0] + by[0], self.center[1] + by[1]), self.radius)

    def resized_to(self, position: Position) -> Circle:
        """The same centre with the rim led through `position`."""
        return Circle(self.center, max(math.dist(self.center, position), SMALLEST_RADIUS))

    def handles(self) -> tuple[Position, ...]:
        """Places on the rim by which it is resized: top, right, bottom, left."""
        (row, col), radius = self.center, self.radius
        return ((row - radius, col), (row, col + radius), (row + radius, col), (row, col - radius))


@dataclass(frozen=True, slots=True)
class Points:
    """Particles placed one by one or sprayed along a stroke.

    Attributes
    ----------
    positions : tuple of tuple of float
        (row, col) of each in px of the image.
    """

    positions: tuple[Position, ...]

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return np.array(self.positions, dtype=np.float64).reshape(-1, 2)

    def moved(self, by: Position) -> Points:
        """The same points displaced by (rows, cols)."""
        return Points(tuple((row + by[0], col + by[1]) for row, col in self.positions))

    def handles(self) -> tuple[Position, ...]:
        """Points have no size to drag, so there are none."""
        return ()


Shape = Circle | Points


def describe(shape: Shape) -> str:
    """The kind of a shape in a word or two, for menus and messages."""
    if isinstance(shape, Circle):
        return "circle"
    return "point" if len(shape.positions) == 1 else "points"
