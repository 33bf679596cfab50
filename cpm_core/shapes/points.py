"""Particles placed one by one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Position
from cpm_core.shapes.checks import check_positions


@dataclass(frozen=True, slots=True)
class Points:
    """Particles placed one by one.

    Attributes
    ----------
    positions : tuple of tuple of float
        (row, col) of each in px of the image, one at least.
    """

    positions: tuple[Position, ...]

    def __post_init__(self) -> None:
        check_positions("positions", self.positions, 1)

    @property
    def title(self) -> str:
        """What it is called."""
        return "point" if len(self.positions) == 1 else "points"

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return np.array(self.positions, dtype=np.float64).reshape(-1, 2)

    @property
    def outline(self) -> NDArray[np.float64]:
        """Points have no line to be drawn."""
        return np.empty((0, 2))

    def moved(self, by: Position) -> Points:
        """The same points displaced by (rows, cols)."""
        return Points(tuple((row + by[0], col + by[1]) for row, col in self.positions))

    def resized(self, by: float) -> Points:
        """Themselves, for they have no size."""
        return self

    def handles(self) -> tuple[Position, ...]:
        """Points have no size to drag, so there are none."""
        return ()

    def with_handle_at(self, handle: Position, to: Position) -> Points:
        """Themselves, for they have no handles."""
        return self

    def distance(self, position: Position) -> float:
        """Distance of a position from the nearest of them [px]."""
        return min(math.dist(point, position) for point in self.positions)

    def encloses(self, position: Position) -> bool:
        """Points enclose nothing."""
        return False
