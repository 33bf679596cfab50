"""What shapes have in common that are drawn as a line around something."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics import polyline
from cpm_core.numerics.polyline import MOST_HANDLES
from cpm_core.numerics.types import Position

A = TypeVar("A", bound="Area")


class Area:
    """A line around something; subclasses are frozen dataclasses.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image, at least three; the last is joined to the first.
    """

    __slots__ = ()

    points: tuple[Position, ...]

    @property
    def outline(self) -> NDArray[np.float64]:
        """Its line for drawing, shape (K, 2), closed."""
        return np.array((*self.points, self.points[0]))

    def moved(self: A, by: Position) -> A:
        """The same displaced by (rows, cols)."""
        return replace(self, points=polyline.moved(self.points, by))  # type: ignore[type-var]

    def resized(self: A, by: float) -> A:
        """The same enlarged around its middle, so that its farthest corner goes so many px outwards."""
        middle = np.mean(self.points, axis=0)
        farthest = max(math.dist(middle, point) for point in self.points)
        factor = max(farthest + by, 1.0) / farthest if farthest > 0.0 else 1.0
        corners = (middle + factor * (np.array(self.points) - middle)).tolist()
        return replace(self, points=tuple((row, col) for row, col in corners))  # type: ignore[type-var]

    def handles(self) -> tuple[Position, ...]:
        """Its corners; there are none of one with so many that they would hide it."""
        return self.points if len(self.points) <= MOST_HANDLES else ()

    def with_handle_at(self: A, handle: Position, to: Position) -> A:
        """The same with the corner next to a handle led to a position."""
        return replace(self, points=polyline.with_handle_at(self.points, handle, to))  # type: ignore[type-var]

    def distance(self, position: Position) -> float:
        """Distance of a position from its line [px]."""
        return polyline.distance((*self.points, self.points[0]), position)

    def encloses(self, position: Position) -> bool:
        """Whether its line winds around a position."""
        return bool(polyline.inside(self.points, np.array([position]))[0])
