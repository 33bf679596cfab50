"""An ellipse of particles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics import polyline
from cpm_core.numerics.types import Position
from cpm_core.particles import initialization
from cpm_core.shapes.checks import LARGEST, check_number
from cpm_core.shapes.circle import SMALLEST_RADIUS

_CORNERS = 180

_ARM, _OUT = 1.25, 4.0
"""How far from the center the handle lies by which it is turned: so many times the first radius, and so many px."""


@dataclass(frozen=True, slots=True)
class Ellipse:
    """An ellipse of particles.

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

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return initialization.loop(self.outline[:-1])

    @property
    def outline(self) -> NDArray[np.float64]:
        """Its line for drawing, shape (K, 2), closed."""
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
        """The same center with both radii changed by so many px."""
        return self._with_radii(self.radii[0] + by, self.radii[1] + by)

    def handles(self) -> tuple[Position, ...]:
        """The four ends of its axes, by which it is resized, and one beyond the first, by which it is turned."""
        (along, across), (first, second) = self._axes(), self.radii
        return (
            self._at(along, first),
            self._at(across, second),
            self._at(along, -first),
            self._at(across, -second),
            self._at(along, _ARM * first + _OUT),
        )

    def with_handle_at(self, handle: Position, to: Position) -> Ellipse:
        """The same center with a radius that reaches a position, or the direction turned towards it."""
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
        """Distance of a position from the rim [px]."""
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
