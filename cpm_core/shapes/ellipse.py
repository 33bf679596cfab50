"""Particles on a circle."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cpm_core.model import starts as initialization
from cpm_core.numerics import polyline
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


_ARM, _OUT = 1.25, 4.0
"""Distance of the rotation handle from the center: a multiple of the first radius, plus a number of px."""


@dataclass(frozen=True, slots=True)
class Ellipse:
    """Particles on an ellipse.

    Attributes
    ----------
    center : tuple of float
        (row, col) in px of the image.
    radii : tuple of float
        Both radii [px], from 0.5 to 100,000.
    angle : float
        Direction of the first radius [rad]: 0 points along the row, a quarter turn down the column.
    """

    title: ClassVar[str] = "ellipse"

    center: Position
    radii: tuple[float, float]
    angle: float = 0.0

    def __post_init__(self) -> None:
        for radius in self.radii:
            check_number("radii", radius)

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 2)."""
        return initialization.loop(self.outline[:-1])

    @property
    def outline(self) -> Array:
        """Vertices of the line, shape (K, 2), the first repeated at the end."""
        turn = np.linspace(0.0, 2.0 * np.pi, _CORNERS)
        (along, across), (first, second) = self._axes(), self.radii
        return np.asarray(
            np.array(self.center)
            + first * np.cos(turn)[:, None] * np.array(along)
            + second * np.sin(turn)[:, None] * np.array(across)
        )

    def moved(self, by: Position) -> Ellipse:
        """The same ellipse displaced by (rows, cols)."""
        return Ellipse((self.center[0] + by[0], self.center[1] + by[1]), self.radii, self.angle)

    def resized(self, by: float) -> Ellipse:
        """The ellipse with both radii changed by so many px."""
        return self._with_radii(self.radii[0] + by, self.radii[1] + by)

    def handles(self) -> tuple[Position, ...]:
        """The four ends of the axes, for resizing, and one beyond the first, for rotation."""
        (along, across), (first, second) = self._axes(), self.radii
        return (
            self._at(along, first),
            self._at(across, second),
            self._at(along, -first),
            self._at(across, -second),
            self._at(along, _ARM * first + _OUT),
        )

    def with_handle_at(self, handle: Position, to: Position) -> Ellipse:
        """The ellipse with the radius of the handle reaching a position, or rotated toward it."""
        handles = self.handles()
        which = min(range(len(handles)), key=lambda index: math.dist(handles[index], handle))
        row, col = to[0] - self.center[0], to[1] - self.center[1]
        if which == len(handles) - 1:
            turned = math.atan2(row, col) if (row, col) != (0.0, 0.0) else self.angle
            return Ellipse(self.center, self.radii, turned)
        down, right = self._axes()[which % 2]
        reached = abs(row * down + col * right)
        first, second = self.radii
        return self._with_radii(reached, second) if which % 2 == 0 else self._with_radii(first, reached)

    def distance(self, position: Position) -> float:
        """Distance of a position from the line [px]."""
        return polyline.distance([(row, col) for row, col in self.outline.tolist()], position)

    def encloses(self, position: Position) -> bool:
        """Whether a position lies inside."""
        row, col = position[0] - self.center[0], position[1] - self.center[1]
        shares = ((row * a[0] + col * a[1]) / radius for a, radius in zip(self._axes(), self.radii, strict=True))
        return sum(share**2 for share in shares) <= 1.0

    def _axes(self) -> tuple[Position, Position]:
        """Directions of the first and the second radius."""
        down, right = math.sin(self.angle), math.cos(self.angle)
        return (down, right), (right, -down)

    def _at(self, direction: Position, distance: float) -> Position:
        return (self.center[0] + distance * direction[0], self.center[1] + distance * direction[1])

    def _with_radii(self, first: float, second: float) -> Ellipse:
        first, second = (min(max(radius, SMALLEST_RADIUS), LARGEST) for radius in (first, second))
        return Ellipse(self.center, (first, second), self.angle)
