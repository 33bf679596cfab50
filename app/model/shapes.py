"""The shapes that a user draws: starts, which give particles, and limits, which hold particles back."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from app.model import paths
from app.model.paths import Position
from cpm_core import initialization

Kind = Literal["grid", "edges", "centers"]
"""Where particles start that nobody has drawn: evenly, on strong edges, or where the electric field diverges."""

KINDS: tuple[Kind, ...] = get_args(Kind)

SMALLEST_RADIUS = 1.0
"""Radius under which a drawn circle is taken for a slip of the hand [px]."""

MOST_HANDLES = 24
"""Corners up to which each of them is a handle; freehand paths have more."""


@dataclass(frozen=True, slots=True)
class Circle:
    """A circle of particles.

    Attributes
    ----------
    center : tuple of float
        (row, col) in px of the image.
    radius : float
        Radius [px], above zero.
    """

    center: Position
    radius: float

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return initialization.circle(self.center, self.radius)

    def moved(self, by: Position) -> Circle:
        """The same circle displaced by (rows, cols)."""
        return Circle((self.center[0] + by[0], self.center[1] + by[1]), self.radius)

    def resized_to(self, position: Position) -> Circle:
        """The same centre with the rim led through `position`."""
        return Circle(self.center, max(math.dist(self.center, position), SMALLEST_RADIUS))

    def handles(self) -> tuple[Position, ...]:
        """Places on the rim by which it is resized: top, right, bottom, left."""
        (row, col), radius = self.center, self.radius
        return ((row - radius, col), (row, col + radius), (row + radius, col), (row, col - radius))


@dataclass(frozen=True, slots=True)
class Points:
    """Particles placed one by one.

    Attributes
    ----------
    positions : tuple of tuple of float
        (row, col) of each in px of the image.
    """

    positions: tuple[Position, ...]

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return np.array(self.positions, dtype=np.float64).reshape(-1, 2)

    def moved(self, by: Position) -> Points:
        """The same points displaced by (rows, cols)."""
        return Points(tuple((row + by[0], col + by[1]) for row, col in self.positions))

    def handles(self) -> tuple[Position, ...]:
        """Points have no size to drag, so there are none."""
        return ()


@dataclass(frozen=True, slots=True)
class Stroke:
    """Particles along a line drawn by hand.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) of the line in px of the image, at least two.
    """

    points: tuple[Position, ...]

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2)."""
        return initialization.stroke(self.points)

    def moved(self, by: Position) -> Stroke:
        """The same stroke displaced by (rows, cols)."""
        return Stroke(paths.moved(self.points, by))

    def handles(self) -> tuple[Position, ...]:
        """Its corners; there are none of one with so many that they would hide it."""
        return self.points if len(self.points) <= MOST_HANDLES else ()

    def reshaped(self, corner: Position, to: Position) -> Stroke:
        """The same stroke with the corner next to a position led to another."""
        return Stroke(paths.led(self.points, corner, to))


@dataclass(frozen=True, slots=True)
class Everywhere:
    """Particles all over the image, where nobody has to draw; which positions they are depends on the image.

    Attributes
    ----------
    kind : {"grid", "edges", "centers"}
        Evenly, on strong edges, or at the centres of divergence of the electric field.
    """

    kind: Kind

    def moved(self, by: Position) -> Everywhere:
        """Itself, for it has no place."""
        return self

    def handles(self) -> tuple[Position, ...]:
        """It has no size to drag, so there are none."""
        return ()


@dataclass(frozen=True, slots=True)
class Region:
    """A region of interest, which particles do not leave.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image, at least three; the last is joined to the first.
    """

    points: tuple[Position, ...]

    @property
    def outline(self) -> tuple[Position, ...]:
        """Its corners with the first repeated at the end."""
        return (*self.points, self.points[0])

    def moved(self, by: Position) -> Region:
        """The same region displaced by (rows, cols)."""
        return Region(paths.moved(self.points, by))

    def handles(self) -> tuple[Position, ...]:
        """Its corners; there are none of one with so many that they would hide it."""
        return self.points if len(self.points) <= MOST_HANDLES else ()

    def reshaped(self, corner: Position, to: Position) -> Region:
        """The same region with the corner next to a position led to another."""
        return Region(paths.led(self.points, corner, to))


@dataclass(frozen=True, slots=True)
class Barrier:
    """A line that particles do not cross.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image, at least two.
    """

    points: tuple[Position, ...]

    @property
    def outline(self) -> tuple[Position, ...]:
        """Its corners, from end to end."""
        return self.points

    def moved(self, by: Position) -> Barrier:
        """The same barrier displaced by (rows, cols)."""
        return Barrier(paths.moved(self.points, by))

    def handles(self) -> tuple[Position, ...]:
        """Its corners; there are none of one with so many that they would hide it."""
        return self.points if len(self.points) <= MOST_HANDLES else ()

    def reshaped(self, corner: Position, to: Position) -> Barrier:
        """The same barrier with the corner next to a position led to another."""
        return Barrier(paths.led(self.points, corner, to))


Start = Circle | Points | Stroke | Everywhere
"""Shapes that give particles."""

Limit = Region | Barrier
"""Shapes that hold particles back."""

Path = Stroke | Region | Barrier
"""Shapes with corners."""

Shape = Start | Limit

_NAMES: dict[type[Shape], str] = {Circle: "circle", Stroke: "stroke", Region: "region of interest", Barrier: "barrier"}
_WAYS: dict[Kind, str] = {"grid": "start everywhere", "edges": "start on strong edges", "centers": "start at centres"}


def describe(shape: Shape) -> str:
    """The kind of a shape in a few words, for menus and messages."""
    if isinstance(shape, Points):
        return "point" if len(shape.positions) == 1 else "points"
    return _WAYS[shape.kind] if isinstance(shape, Everywhere) else _NAMES[type(shape)]
