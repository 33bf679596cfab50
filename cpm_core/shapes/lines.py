"""Shapes that are a line: strokes and polygons give particles, barriers and regions of interest hold them back.

Strokes and polygons lie in an image, or in a volume, where each corner may lie in another slice.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cpm_core.model import starts as initialization
from cpm_core.numerics.types import Array, Place, Position
from cpm_core.shapes.path import ClosedPath, OpenPath


@dataclass(frozen=True, slots=True)
class Stroke(OpenPath):
    """Particles along a freehand line; a stroke with a single corner is one particle."""

    title: ClassVar[str] = "stroke"
    least: ClassVar[int] = 1

    points: tuple[Place, ...]

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 2), or (N, 3) in a volume."""
        return initialization.stroke(self.points)


@dataclass(frozen=True, slots=True)
class Polygon(ClosedPath):
    """Particles along a closed line."""

    title: ClassVar[str] = "polygon"

    points: tuple[Place, ...]

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 2), or (N, 3) in a volume."""
        return initialization.loop(self.points)


@dataclass(frozen=True, slots=True)
class Region(ClosedPath):
    """A region of interest, which particles do not leave."""

    title: ClassVar[str] = "region of interest"

    points: tuple[Position, ...]

    def encloses(self, position: Position) -> bool:
        """Always false: a region is selected at its line only, since other shapes lie inside it."""
        return False


@dataclass(frozen=True, slots=True)
class Barrier(OpenPath):
    """A line that particles do not cross."""

    title: ClassVar[str] = "barrier"

    points: tuple[Position, ...]
