"""Particles along a line drawn by hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cpm_core.numerics.types import Array, Position
from cpm_core.particles import initialization
from cpm_core.shapes.path import OpenPath


@dataclass(frozen=True, slots=True)
class Stroke(OpenPath):
    """Particles along a line drawn by hand.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) of the line in px of the image; a single one is a stroke of one particle.
    """

    title: ClassVar[str] = "stroke"
    least: ClassVar[int] = 1

    points: tuple[Position, ...]

    def seeds(self) -> Array:
        """Positions of its particles, shape (N, 2)."""
        return initialization.stroke(self.points)
