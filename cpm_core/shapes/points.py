"""Particles placed one by one."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass

import numpy as np

from cpm_core.numerics.types import Array, Place
from cpm_core.shapes.path import WithoutOutline, check_positions


@dataclass(frozen=True, slots=True)
class Points(WithoutOutline):
    """Particles placed one by one: `positions` (row, col) [px], or (plane, row, col) [voxels], at least one."""

    positions: tuple[Place, ...]

    def __post_init__(self) -> None:
        check_positions("positions", self.positions, 1)
        if len({len(position) for position in self.positions}) > 1:
            raise ValueError("positions in an image and in a volume are mixed: give all of them as many numbers.")

    @property
    def title(self) -> str:
        """Name for the user."""
        return "point" if len(self.positions) == 1 else "points"

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 2), or (N, 3) in a volume."""
        return np.array(self.positions, dtype=np.float64)

    def moved(self, by: Place) -> Points:
        """The same points displaced by so much along each axis."""
        return Points(tuple(tuple(map(operator.add, position, by)) for position in self.positions))

    def distance(self, position: Place) -> float:
        """Distance of a position from the nearest point [px]."""
        return min(math.dist(point, position) for point in self.positions)
