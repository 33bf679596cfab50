"""Shapes that are a line: strokes and polygons give particles, barriers and regions of interest hold them back.

Strokes and polygons lie in an image, or in a volume, where each corner may lie in another slice.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from cpm_core.model import starts as initialization
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Place, Position, frozen
from cpm_core.shapes.path import ClosedPath, OpenPath, WithoutOutline, check_positions


@frozen
class Stroke(OpenPath):
    """Particles along a freehand line; a stroke with a single corner is one particle."""

    title: ClassVar[str] = "stroke"
    least: ClassVar[int] = 1

    points: tuple[Place, ...]

    def seeds(self) -> Array:
        """Return the positions of the particles, shape (N, 2), or (N, 3) in a volume."""
        return initialization.stroke(self.points)


@frozen
class Polygon(ClosedPath):
    """Particles along a closed line."""

    title: ClassVar[str] = "polygon"

    points: tuple[Place, ...]

    def seeds(self) -> Array:
        """Return the positions of the particles, shape (N, 2), or (N, 3) in a volume."""
        return initialization.closed_stroke(self.points)


@frozen
class PolygonRegion(ClosedPath):
    """A region of interest, which particles do not leave."""

    title: ClassVar[str] = "region of interest"

    def encloses(self, position: Position) -> bool:
        """Return False: a region is selected at its line only, since other shapes lie inside it."""
        return False


@frozen
class Barrier(OpenPath):
    """A line that particles do not cross."""

    title: ClassVar[str] = "barrier"


@frozen
class Points(WithoutOutline):
    """Particles placed one by one: `positions` (row, col) [px], or (plane, row, col) [voxels], at least one."""

    positions: tuple[Place, ...]

    def __post_init__(self) -> None:
        check_positions("positions", self.positions, 1)

    @property
    def title(self) -> str:
        """Name for the user."""
        return "point" if len(self.positions) == 1 else "points"

    def seeds(self) -> Array:
        """Return the positions of the particles, shape (N, 2), or (N, 3) in a volume."""
        return np.array(self.positions, float)

    def translated(self, offset: Place) -> Points:
        """Return the points displaced along each axis."""
        return Points(polyline.translate_path(self.positions, offset))

    def distance_to(self, position: Place) -> float:
        """Measure the distance of a position from the nearest point [px]."""
        return min(math.dist(point, position) for point in self.positions)
