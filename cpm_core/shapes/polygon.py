"""Particles along a line that ends where it begins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Position
from cpm_core.particles import initialization
from cpm_core.shapes.path import ClosedPath


@dataclass(frozen=True, slots=True)
class Polygon(ClosedPath):
    """Particles along a line that ends where it begins.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image, three different ones at least; the last is joined to the first.
    """

    title: ClassVar[str] = "polygon"

    points: tuple[Position, ...]

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return initialization.loop(self.points)
