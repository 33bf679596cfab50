"""A line that particles do not cross."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics import polyline
from cpm_core.numerics.polyline import MOST_HANDLES
from cpm_core.numerics.types import Position


@dataclass(frozen=True, slots=True)
class Barrier:
    """A line that particles do not cross.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image, at least two.
    """

    title: ClassVar[str] = "barrier"

    points: tuple[Position, ...]

    @property
    def outline(self) -> NDArray[np.float64]:
        """Its line for drawing, shape (K, 2)."""
        return np.array(self.points)

    def moved(self, by: Position) -> Barrier:
        """The same barrier displaced by (rows, cols)."""
        return Barrier(polyline.moved(self.points, by))

    def resized(self, by: float) -> Barrier:
        """Itself: its corners are what it is reshaped by."""
        return self

    def handles(self) -> tuple[Position, ...]:
        """Its corners; there are none of one with so many that they would hide it."""
        return self.points if len(self.points) <= MOST_HANDLES else ()

    def with_handle_at(self, handle: Position, to: Position) -> Barrier:
        """The same barrier with the corner next to a handle led to a position."""
        return Barrier(polyline.with_handle_at(self.points, handle, to))

    def distance(self, position: Position) -> float:
        """Distance of a position from its line [px]."""
        return polyline.distance(self.points, position)

    def encloses(self, position: Position) -> bool:
        """It is taken hold of by its line only."""
        return False
