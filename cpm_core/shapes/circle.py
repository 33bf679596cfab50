"""Particles on a circle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cpm_core.model import starts as initialization
from cpm_core.numerics.types import Array, Position
from cpm_core.shapes.path import LARGEST, check_number

SMALLEST_RADIUS = 1.0
"""Radius under which a drawn circle is taken for an accidental click [px]."""

_CORNERS = 180


@dataclass(frozen=True, slots=True)
class Circle:
    """Particles on a circle.

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

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 2)."""
        return initialization.circle(self.center, self.radius)

    @property
    def outline(self) -> Array:
        """Vertices of the line, shape (K, 2), the first repeated at the end."""
        angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS)
        return np.array(self.center) + self.radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)

    def moved(self, by: Position) -> Circle:
        """The same circle displaced by (rows, cols)."""
        return Circle((self.center[0] + by[0], self.center[1] + by[1]), self.radius)

    def resized(self, by: float) -> Circle:
        """The circle with its radius changed by so many px."""
        return self._with_radius(self.radius + by)

    def handles(self) -> tuple[Position, ...]:
        """Positions on the line for resizing: top, right, bottom, left."""
        (row, col), radius = self.center, self.radius
        return ((row - radius, col), (row, col + radius), (row + radius, col), (row, col - radius))

    def with_handle_at(self, handle: Position, to: Position) -> Circle:
        """The circle with the same center through a position, for any handle."""
        return self._with_radius(math.dist(self.center, to))

    def distance(self, position: Position) -> float:
        """Distance of a position from the line [px]."""
        return abs(math.dist(self.center, position) - self.radius)

    def encloses(self, position: Position) -> bool:
        """Whether a position lies inside."""
        return math.dist(self.center, position) <= self.radius

    def _with_radius(self, radius: float) -> Circle:
        return Circle(self.center, min(max(radius, SMALLEST_RADIUS), LARGEST))
