"""Common parts of shapes: checks of values, and the behavior of open lines, closed lines and single positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar, Self

import numpy as np

from cpm_core.numerics import polyline
from cpm_core.numerics.polyline import MAX_CORNER_HANDLES
from cpm_core.numerics.types import NO_POINTS, Array, Line, Place, frozen

MIN_SIZE = 0.5
"""Least radius, and distance between particles [px]."""

LARGEST_SIZE = 1e5
"""Largest radius, and distance between particles [px]."""


def check_number(name: str, value: float, low: float = MIN_SIZE, high: float = LARGEST_SIZE) -> None:
    """Check that a number of a shape lies within its bounds, else raise ValueError."""
    if not low <= value <= high:
        raise ValueError(f"{name} is {value:g} but must be a number from {low:g} to {high:g}.")


def check_positions(name: str, positions: Sequence[Place], least: int) -> None:
    """Check that enough corners or points of a shape differ, and have as many axes, else raise ValueError."""
    different = len(set(positions))
    if different < least:
        raise ValueError(f"{different} different {name} are given but at least {least} are needed.")
    if len(set(map(len, positions))) > 1:
        raise ValueError(f"{name} in an image and in a volume are mixed: give all of them as many numbers.")


class WithoutOutline:
    """Shape without an outline: it has no handles, no size and no inside. Subclasses are frozen dataclasses."""

    @property
    def outline(self) -> Array:
        """Empty outline, shape (0, 2)."""
        return NO_POINTS

    def resized_by(self, amount: float) -> Self:
        """Return the shape itself: it has no size."""
        return self

    def handles(self) -> tuple[Place, ...]:
        """Return no handles: the shape is dragged as a whole."""
        return ()

    def with_handle_at(self, handle: Place, position: Place) -> Self:
        """Return the shape itself: it has no handles."""
        return self

    def encloses(self, position: Place) -> bool:
        """Return False: it has no inside."""
        return False


@frozen
class OpenPath(WithoutOutline):
    """A line from corner to corner.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image; of some lines also (plane, row, col) [voxels].
    least : int
        How many of them must differ; with fewer, ValueError is raised.
    """

    least: ClassVar[int] = 2

    points: Line

    def __post_init__(self) -> None:
        check_positions("points", self.points, self.least)

    @property
    def outline(self) -> Array:
        """Vertices of the line, shape (K, D)."""
        return polyline.corners_of(self.points)

    def translated(self, offset: Place) -> Self:
        """Return the shape displaced along each axis."""
        return self._with_points(polyline.translate_path(self.points, offset))

    def handles(self) -> tuple[Place, ...]:
        """Return the corners; none where there are so many that they would hide the line."""
        return self.points if len(self.points) <= MAX_CORNER_HANDLES else ()

    def with_handle_at(self, handle: Place, to: Place) -> Self:
        """Return the shape with the corner nearest to a handle moved; unchanged where too few corners would differ."""
        return self._with_points(polyline.move_corner(self.points, handle, to))

    def distance_to(self, position: Place) -> float:
        """Measure the distance of a position from the line [px]."""
        return polyline.distance_to_path(self.points, position)

    def _with_points(self, points: tuple[Place, ...]) -> Self:
        return replace(self, points=points) if len(set(points)) >= self.least else self


@frozen
class ClosedPath(OpenPath):
    """A line around an area; the last corner is joined to the first."""

    least: ClassVar[int] = 3

    @property
    def outline(self) -> Array:
        """Vertices of the line, shape (K, D), the first repeated at the end."""
        corners = polyline.corners_of(self.points)
        return np.concatenate([corners, corners[:1]])

    def resized_by(self, by: float) -> Self:
        """Enlarge the shape around its center, so that its farthest corner moves outward by a number of px."""
        off = polyline.corners_of(self.points)
        center = off.mean(axis=0)
        farthest = np.linalg.norm(off - center, axis=1).max()
        corners = (center + max(farthest + by, 1.0) / farthest * (off - center)).tolist()
        return self._with_points(tuple(map(tuple, corners)))

    def distance_to(self, position: Place) -> float:
        """Measure the distance of a position from the line [px]."""
        return polyline.distance_to_path(self.outline, position)

    def encloses(self, position: Place) -> bool:
        """Return whether the line winds around a position; no line in a volume encloses any."""
        return len(position) == 2 and bool(polyline.points_inside(self.points, np.array([position]))[0])
