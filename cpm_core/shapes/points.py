"""Particles placed one by one."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cpm_core.numerics.types import Array, Position
from cpm_core.shapes.path import WithoutOutline, check_positions


@dataclass(frozen=True, slots=True)
class Points(WithoutOutline):
    """Particles placed one by one: `positions` (row, col) in px of the image, at least one."""

    positions: tuple[Position, ...]

    def __post_init__(self) -> None:
        check_positions("positions", self.positions, 1)

    @property
    def title(self) -> str:
        """Name for the user."""
        return "point" if len(self.positions) == 1 else "points"

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 2)."""
        return np.array(self.positions, dtype=np.float64).reshape(-1, 2)

    def moved(self, by: Position) -> Points:
        """The same points displaced by (rows, cols)."""
        return Points(tuple((row + by[0], col + by[1]) for row, col in self.positions))

    def distance(self, position: Position) -> float:
        """Distance of a position from the nearest point [px]."""
        return min(math.dist(point, position) for point in self.positions)
