"""Particles along a line drawn by hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics import polyline
from cpm_core.numerics.polyline import MOST_HANDLES
from cpm_core.numerics.types import Position
from cpm_core.particles import initialization


@dataclass(frozen=True, slots=True)
class Stroke:
    """Particles along a line drawn by hand.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) of the line in px of the image, at least two.
    """

    title: ClassVar[str] = "stroke"

    points: tuple[Position, ...]

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return initialization.stroke(self.points)

    @property
    def outline(self) -> NDArray[np.float64]:
        """Its line for drawing, shape (K, 2)."""
        return np.array(self.points)

    def moved(self, by: Position) -> Stroke:
        """The same stroke displaced by (rows, cols)."""
        return Stroke(polyline.moved(self.points, by))

    def resized(self, by: float) -> Stroke:
        """Itself: its corners are what it is reshaped by."""
        return self

    def handles(self) -> tuple[Position, ...]:
        """Its corners; there are none of one with so many that they would hide it."""
        return self.points if len(self.points) <= MOST_HANDLES else ()

    def with_handle_at(self, handle: Position, to: Position) -> Stroke:
        """The same stroke with the corner next to a handle led to a position."""
        return Stroke(polyline.with_handle_at(self.points, handle, to))

    def distance(self, position: Position) -> float:
        """Distance of a position from its line [px]."""
        return polyline.distance(self.points, position)

    def encloses(self, position: Position) -> bool:
        """It is taken hold of by its line only."""
        return False
