"""A region of interest, which particles do not leave."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cpm_core import paths
from cpm_core.paths import MOST_HANDLES, Position


@dataclass(frozen=True, slots=True)
class Region:
    """A region of interest, which particles do not leave.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image, at least three; the last is joined to the first.
    """

    title: ClassVar[str] = "region of interest"

    points: tuple[Position, ...]

    @property
    def outline(self) -> NDArray[np.float64]:
        """Its line for drawing, shape (K, 2), closed."""
        return np.array((*self.points, self.points[0]))

    def moved(self, by: Position) -> Region:
        """The same region of interest displaced by (rows, cols)."""
        return Region(paths.moved(self.points, by))

    def grown(self, by: float) -> Region:
        """Itself: its corners are what it is reshaped by."""
        return self

    def handles(self) -> tuple[Position, ...]:
        """Its corners; there are none of one with so many that they would hide it."""
        return self.points if len(self.points) <= MOST_HANDLES else ()

    def led(self, handle: Position, to: Position) -> Region:
        """The same region of interest with the corner next to a handle led to a position."""
        return Region(paths.led(self.points, handle, to))

    def distance(self, position: Position) -> float:
        """Distance of a position from its line [px]."""
        return paths.distance((*self.points, self.points[0]), position)

    def encloses(self, position: Position) -> bool:
        """It is taken hold of by its line only."""
        return False
