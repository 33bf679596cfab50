"""A circle of particles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Position
from cpm_core.particles import initialization
from cpm_core.shapes.checks import LARGEST, check_number

SMALLEST_RADIUS = 1.0
"""Radius under which a drawn circle is taken for a slip of the hand [px]."""

_CORNERS = 180


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle of particles.

    Attributes
    ----------
    center : tuple of float
        (row, col) in px of the image.
    radius : float
        Radius [px], from 0.5 to 100,000.
    """

    title: ClassVar[str] = "circle"

    center: Position
    radius: float

    def __post_init__(self) -> None:
        check_number("radius", self.radius)

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return initialization.circle(self.center, self.radius)

    @property
    def outline(self) -> NDArray[np.float64]:
        """Its line for drawing, shape (K, 2), closed."""
        angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS)
        return np.array(self.center) + self.radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)

    def moved(self, by: Position) -> Circle:
        """The same circle displaced by (rows, cols)."""
        return Circle((self.center[0] + by[0], self.center[1] + by[1]), self.radius)

    def resized(self, by: float) -> Circle:
        """The same center with the radius changed by so many px."""
        return self._with_radius(self.radius + by)

    def handles(self) -> tuple[Position, ...]:
        """Places on the rim by which it is resized: top, right, bottom, left."""
        (row, col), radius = self.center, self.radius
        return ((row - radius, col), (row, col + radius), (row + radius, col), (row, col - radius))

    def with_handle_at(self, handle: Position, to: Position) -> Circle:
        """The same center with the rim moved through a position, whichever handle is dragged there."""
        return self._with_radius(math.dist(self.center, to))

    def distance(self, position: Position) -> float:
        """Distance of a position from the rim [px]."""
        return abs(math.dist(self.center, position) - self.radius)

    def encloses(self, position: Position) -> bool:
        """Whether a position lies inside."""
        return math.dist(self.center, position) <= self.radius

    def _with_radius(self, radius: float) -> Circle:
        return Circle(self.center, min(max(radius, SMALLEST_RADIUS), LARGEST))
