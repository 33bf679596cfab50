"""Particles on a circle or an ellipse."""

from __future__ import annotations

import math
import operator
from dataclasses import replace
from typing import ClassVar, Self

import numpy as np

from cpm_core.model import starts as initialization
from cpm_core.numerics import polyline
from cpm_core.numerics.polyline import as_line
from cpm_core.numerics.types import Array, Line, Place, Position, frozen
from cpm_core.shapes.path import LARGEST_SIZE, check_number

SMALLEST_RADIUS = 1.0
"""Radius under which a drawn circle or sphere is taken for an accidental click [px, sides of the smallest voxel]."""

_OUTLINE_CORNERS = 180
"""Number of vertices of the outline of a circle or an ellipse."""


class Centered:
    """Shape with a center. Subclasses are frozen dataclasses."""

    center: Place

    def translated(self, offset: Place) -> Self:
        """Return the shape displaced along each axis."""
        return replace(self, center=tuple(map(operator.add, self.center, offset)))  # type: ignore[type-var]


class Round(Centered):
    """Shape whose outline is equally far from its center all around. Subclasses are frozen dataclasses."""

    radius: float

    def resized_by(self, amount: float) -> Self:
        """Return the shape with its radius changed."""
        return self._with_radius(self.radius + amount)

    def with_handle_at(self, handle: Place, position: Place) -> Self:
        """Return the shape with the same center through a position, for any handle."""
        return self._with_radius(self.distance_from_center(position))

    def distance_from_center(self, position: Place) -> float:
        """Measure the distance of a position from the center, in the unit of the radius."""
        return math.dist(self.center, position)

    def distance_to(self, position: Place) -> float:
        """Measure the distance of a position from the line or the surface, in the unit of the radius."""
        return abs(self.distance_from_center(position) - self.radius)

    def encloses(self, position: Place) -> bool:
        """Return whether a position lies inside."""
        return self.distance_from_center(position) <= self.radius

    def _with_radius(self, radius: float) -> Self:
        return replace(self, radius=min(max(radius, SMALLEST_RADIUS), LARGEST_SIZE))  # type: ignore[type-var]


@frozen
class Circle(Round):
    """Particles on a circle.

    Attributes
    ----------
    center : tuple of float
        (row, col) in px of the image.
    radius : float
        Radius [px], from 0.5 to 100,000.
    """

    title: ClassVar[str] = "circle"

    center: Position
    radius: float

    def __post_init__(self) -> None:
        check_number("radius", self.radius)

    def seeds(self) -> Array:
        """Return the positions of the particles, shape (N, 2)."""
        return initialization.circle(self.center, self.radius)

    @property
    def outline(self) -> Array:
        """Vertices of the line, shape (K, 2), the first repeated at the end."""
        angle = np.linspace(0.0, 2.0 * np.pi, _OUTLINE_CORNERS)
        return np.array(self.center) + self.radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)

    def handles(self) -> Line:
        """Return the positions on the line for resizing: top, right, bottom, left."""
        (row, col), radius = self.center, self.radius
        return ((row - radius, col), (row, col + radius), (row + radius, col), (row, col - radius))


class Elongated(Centered):
    """Shape with a radius along each of two axes. Subclasses are frozen dataclasses."""

    radii: tuple[float, float]

    def __post_init__(self) -> None:
        for radius in self.radii:
            check_number("radii", radius)

    @property
    def outline(self) -> Array:
        """Vertices of the line, shape (K, D), the first repeated at the end."""
        raise NotImplementedError

    def resized_by(self, amount: float) -> Self:
        """Return the shape with both radii changed by a number of px."""
        return self._with_radii(self.radii[0] + amount, self.radii[1] + amount)

    def distance_to(self, position: Place) -> float:
        """Measure the distance of a position from the line [px]."""
        return polyline.distance_to_path(self.outline, position)

    def _with_radii(self, *radii: float) -> Self:
        allowed = tuple(min(max(radius, SMALLEST_RADIUS), LARGEST_SIZE) for radius in radii)
        return replace(self, radii=allowed)  # type: ignore[type-var]


_ROTATION_ARM = 1.25
"""Distance of the rotation handle from the center, in first radii, before `_ROTATION_OFFSET`."""

_ROTATION_OFFSET = 4.0
"""Additional distance of the rotation handle [px]."""


@frozen
class Ellipse(Elongated):
    """Particles on an ellipse.

    Attributes
    ----------
    center : tuple of float
        (row, col) in px of the image.
    radii : tuple of float
        Both radii [px], from 0.5 to 100,000.
    angle : float
        Direction of the first radius [rad]: 0 points along the row, a quarter turn down the column.
    """

    title: ClassVar[str] = "ellipse"

    center: Position
    radii: tuple[float, float]
    angle: float = 0.0

    def seeds(self) -> Array:
        """Return the positions of the particles, shape (N, 2)."""
        return initialization.closed_stroke(self.outline[:-1])

    @property
    def outline(self) -> Array:
        """Vertices of the line, shape (K, 2), the first repeated at the end."""
        turn = np.linspace(0.0, 2.0 * np.pi, _OUTLINE_CORNERS)
        (along, across), (first, second) = self._axes, self.radii
        return np.array(self.center) + first * np.cos(turn)[:, None] * along + second * np.sin(turn)[:, None] * across

    def handles(self) -> Line:
        """Return the four ends of the axes, for resizing, and one place beyond the first, for rotation."""
        first, second = np.array(self.radii)[:, None] * self._axes
        beyond = (_ROTATION_ARM * self.radii[0] + _ROTATION_OFFSET) * self._axes[0]
        return as_line(np.array([first, second, -first, -second, beyond]) + self.center)

    def with_handle_at(self, handle: Position, position: Position) -> Ellipse:
        """Return the ellipse with the radius of the handle reaching a position, or rotated toward it."""
        handles = self.handles()
        which = min(range(len(handles)), key=lambda index: math.dist(handles[index], handle))
        row, col = map(operator.sub, position, self.center)
        if which == len(handles) - 1:
            return replace(self, angle=math.atan2(row, col) if row or col else self.angle)
        reached = abs(float(self._axes[which % 2] @ (row, col)))
        first, second = self.radii
        return self._with_radii(reached, second) if which % 2 == 0 else self._with_radii(first, reached)

    def encloses(self, position: Position) -> bool:
        """Return whether a position lies inside."""
        shares = self._axes @ np.subtract(position, self.center) / self.radii
        return bool(shares @ shares <= 1.0)

    @property
    def _axes(self) -> Array:
        """Directions of the first and the second radius, shape (2, 2)."""
        down, right = math.sin(self.angle), math.cos(self.angle)
        return np.array([(down, right), (right, -down)])
