"""What shapes have in common that are drawn as a line, from corner to corner or around an area."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar, Self

import numpy as np

from cpm_core.numerics import polyline
from cpm_core.numerics.polyline import MOST_HANDLES
from cpm_core.numerics.types import Array, Position
from cpm_core.shapes.checks import check_positions


class OpenPath:
    """A line from corner to corner; subclasses are frozen dataclasses.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image.
    least : int
        How many of them must differ.

    Raises
    ------
    ValueError
        When fewer differ.
    """

    __slots__ = ()

    least: ClassVar[int] = 2

    points: tuple[Position, ...]

    def __post_init__(self) -> None:
        check_positions("points", self.points, self.least)

    @property
    def outline(self) -> Array:
        """Its line for drawing, shape (K, 2)."""
        return np.array(self.points)

    def moved(self, by: Position) -> Self:
        """The same displaced by (rows, cols)."""
        return self._with_points(polyline.moved(self.points, by))

    def resized(self, by: float) -> Self:
        """Itself: its corners are what it is reshaped by."""
        return self

    def handles(self) -> tuple[Position, ...]:
        """Its corners; there are none of one with so many that they would hide it."""
        return self.points if len(self.points) <= MOST_HANDLES else ()

    def with_handle_at(self, handle: Position, to: Position) -> Self:
        """The same with the corner next to a handle moved to a position; itself where too few corners would differ."""
        return self._with_points(polyline.with_handle_at(self.points, handle, to))

    def distance(self, position: Position) -> float:
        """Distance of a position from its line [px]."""
        return polyline.distance(self.points, position)

    def encloses(self, position: Position) -> bool:
        """It is taken hold of by its line only."""
        return False

    def _with_points(self, points: tuple[Position, ...]) -> Self:
        return replace(self, points=points) if len(set(points)) >= self.least else self  # type: ignore[type-var]


class ClosedPath(OpenPath):
    """A line around an area; the last corner is joined to the first. Subclasses are frozen dataclasses."""

    __slots__ = ()

    least: ClassVar[int] = 3

    @property
    def outline(self) -> Array:
        """Its line for drawing, shape (K, 2), closed."""
        return np.array((*self.points, self.points[0]))

    def resized(self, by: float) -> Self:
        """The same enlarged around its middle, so that its farthest corner goes so many px outwards."""
        middle = np.mean(self.points, axis=0)
        farthest = max(math.dist(middle, point) for point in self.points)
        corners = (middle + max(farthest + by, 1.0) / farthest * (np.array(self.points) - middle)).tolist()
        return self._with_points(tuple((row, col) for row, col in corners))

    def distance(self, position: Position) -> float:
        """Distance of a position from its line [px]."""
        return polyline.distance((*self.points, self.points[0]), position)

    def encloses(self, position: Position) -> bool:
        """Whether its line winds around a position."""
        return bool(polyline.inside(self.points, np.array([position]))[0])
