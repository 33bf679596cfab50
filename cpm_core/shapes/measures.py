"""Measures that a user draws: a ruler, an angle, and an ellipse around gray values; no particle feels them."""

from __future__ import annotations

import math
import operator
from collections.abc import Iterable
from typing import ClassVar

import numpy as np

from cpm_core.image.image import Image
from cpm_core.numerics.types import Array, Extent, Line, Mask, Place, Position, frozen
from cpm_core.shapes.ellipse import Ellipse, Elongated
from cpm_core.shapes.path import OpenPath


@frozen
class MeasuredValues:
    """What a measure measures in an image; None for what it does not.

    Attributes
    ----------
    length : float or None
        Length [unit of the image].
    angle : float or None
        Angle [degrees].
    area : float or None
        Area [unit of the image, squared].
    mean, deviation : float or None
        Mean and standard deviation of the gray levels of the pixels whose centers lie inside; None without any.
    pixels : int or None
        Number of these pixels.
    """

    length: float | None = None
    angle: float | None = None
    area: float | None = None
    mean: float | None = None
    deviation: float | None = None
    pixels: int | None = None


@frozen
class Ruler(OpenPath):
    """The distance of two points."""

    title: ClassVar[str] = "ruler"

    points: tuple[Place, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_count(self, 2)

    def measure(self, image: Image, channel: str = "luminance") -> MeasuredValues:
        """Measure the distance in an image."""
        begin, end = np.array(self.points) * image.spacing
        return MeasuredValues(length=math.dist(begin, end))


@frozen
class Angle(OpenPath):
    """The angle at the second of three points."""

    title: ClassVar[str] = "angle"
    least: ClassVar[int] = 3

    points: tuple[Place, ...]

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_count(self, 3)

    def measure(self, image: Image, channel: str = "luminance") -> MeasuredValues:
        """Measure the angle in an image, from 0 to 180 degrees."""
        begin, corner, end = np.array(self.points) * image.spacing
        one, other = ((each - corner) / np.linalg.norm(each - corner) for each in (begin, end))
        # well-conditioned for any angle, as the cosine is not
        turn = 2.0 * math.atan2(float(np.linalg.norm(one - other)), float(np.linalg.norm(one + other)))
        return MeasuredValues(angle=math.degrees(turn))


@frozen
class Oval(Elongated):
    """An ellipse along the axes of an image, or of a slice of a volume, in which gray levels are measured.

    Attributes
    ----------
    center : tuple of float
        (row, col), or (plane, row, col) in a volume [px of the image].
    radii : tuple of float
        Radii along the two axes in their order [px], from 0.5 to 100,000.
    axis : int
        Axis of the volume across which its slice lies.
    """

    title: ClassVar[str] = "measuring ellipse"

    center: Place
    radii: tuple[float, float]
    axis: int = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.axis not in range(3):
            raise ValueError(f"axis is {self.axis} but must be 0, 1 or 2.")

    @property
    def outline(self) -> Array:
        """Vertices of the line, shape (K, D), the first repeated at the end."""
        flat = self._flat.outline
        return flat if len(self.center) == 2 else np.insert(flat, self.axis, self.center[self.axis], axis=1)

    def handles(self) -> Line:
        """Return the four ends of its axes."""
        return tuple(map(self._lift, self._flat.handles()[:4]))

    def with_handle_at(self, handle: Place, position: Place) -> Oval:
        """Return the ellipse with the radius of the handle reaching a position."""
        away, to = (tuple(map(abs, map(operator.sub, self._drop(at), self._flat.center))) for at in (handle, position))
        which = int(away[1] > away[0])
        radii = (to[index] if index == which else radius for index, radius in enumerate(self.radii))
        return self._with_radii(*radii)

    def encloses(self, position: Place) -> bool:
        """Return whether a position lies inside, in its slice."""
        return self._flat.encloses(self._drop(position)) and (
            len(position) == 2 or abs(position[self.axis] - self.center[self.axis]) <= 0.5
        )

    def measure(self, image: Image, channel: str = "luminance") -> MeasuredValues:
        """Measure its area, and the gray levels inside, in a channel of `Parameters.channel`."""
        sides = self._drop(image.spacing)
        window, inside = self._find_pixels(tuple(map(int, self._drop(image.shape))))
        if len(self.center) == 3:
            place = min(max(round(self.center[self.axis]), 0), image.shape[self.axis] - 1)
            window = (*window[: self.axis], slice(place, place + 1), *window[self.axis :])
        area = math.pi * math.prod(self.radii) * math.prod(sides)
        if not inside.any():
            return MeasuredValues(area=area, pixels=0)
        levels = image.gray_levels_in(window, channel).reshape(inside.shape)[inside]
        return MeasuredValues(
            area=area, mean=float(levels.mean()), deviation=float(levels.std()), pixels=int(inside.sum())
        )

    def _find_pixels(self, shape: Extent) -> tuple[tuple[slice, ...], Mask]:
        """Find the pixels of its slice whose centers lie inside: the window around them, and a mask in it."""
        flat = self._flat
        ends = [
            (max(math.ceil(at - radius), 0), min(math.floor(at + radius) + 1, side))
            for at, radius, side in zip(flat.center, self.radii, shape, strict=True)
        ]
        rows, cols = (
            (np.arange(first, last) - at) / radius
            for (first, last), at, radius in zip(ends, flat.center, self.radii, strict=True)
        )
        return tuple(slice(*each) for each in ends), rows[:, None] ** 2 + cols**2 <= 1.0

    @property
    def _flat(self) -> Ellipse:
        """The ellipse in its slice."""
        down, right = self._drop(self.center)
        return Ellipse((down, right), self.radii[::-1])

    def _drop(self, place: tuple[float, ...]) -> Position:
        """Return the numbers of a place along the two axes of its slice."""
        return place if len(place) == 2 else (*place[: self.axis], *place[self.axis + 1 :])

    def _lift(self, position: Position) -> Place:
        """Return the place of a position in its slice."""
        at = self.center
        return position if len(at) == 2 else (*position[: self.axis], at[self.axis], *position[self.axis :])


Measure = Ruler | Angle | Oval
"""Shapes that measure."""


def select_measures(shapes: Iterable[object]) -> tuple[Measure, ...]:
    """Select the shapes that measure."""
    return tuple(shape for shape in shapes if isinstance(shape, Measure))


def _check_count(shape: Ruler | Angle, count: int) -> None:
    if len(shape.points) != count:
        raise ValueError(f"{len(shape.points)} points are given for the {shape.title}, but it has {count}.")
