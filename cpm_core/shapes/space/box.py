"""Boxes in a volume: particles on their faces, or a region of interest."""

from __future__ import annotations

import math
import operator
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import ClassVar, Self

import numpy as np

from cpm_core.image.volume_regions import Pair
from cpm_core.model.volume import starts as volume_starts
from cpm_core.numerics.types import Array, Place, Voxel
from cpm_core.shapes.path import LARGEST, WithoutOutline

SMALLEST = 1.0
"""Least side of a box [voxels]."""

_APART, _MOST = 2.0, 10_000
"""Least distance between particles on the faces [voxels], and about how many there are on a large box."""

_SAME = 1e-6
"""Distance within which a handle lies on a face [voxels]."""

_CORNERS = np.array(list(product((False, True), repeat=3)))
"""Which corners of a box lie on the last face across each axis."""


class Cuboid(WithoutOutline):
    """A box whose faces lie across the axes of the volume. Subclasses are frozen dataclasses.

    Attributes
    ----------
    first, last : tuple of float
        The corners next to the first and to the last voxel of the volume, (plane, row, col) [voxels].
    """

    __slots__ = ()

    first: Voxel
    last: Voxel

    def __post_init__(self) -> None:
        low, high = np.sort([self.first, self.last], axis=0).tolist()
        if not all(math.isfinite(end) and abs(end) <= LARGEST for end in (*low, *high)):
            raise ValueError(f"the corners of the box are {self.first} and {self.last} but must be in the volume.")
        if min(map(operator.sub, high, low)) < SMALLEST - _SAME:
            raise ValueError(
                f"the corners of the box are {self.first} and {self.last} but must be a voxel apart along every axis."
            )
        object.__setattr__(self, "first", tuple(low))
        object.__setattr__(self, "last", tuple(high))

    @property
    def center(self) -> Voxel:
        """(plane, row, col) [voxels]."""
        return tuple(0.5 * (low + high) for low, high in zip(self.first, self.last, strict=True))

    @property
    def outline(self) -> Array:
        """The corners, shape (8, 3)."""
        return np.where(_CORNERS, self.last, self.first)

    def moved(self, by: Place) -> Self:
        """The same box displaced by so much along each axis."""
        return self._between(tuple(map(operator.add, self.first, by)), tuple(map(operator.add, self.last, by)))

    def resized(self, by: float) -> Self:
        """The box with each face moved outward."""
        low, high = np.array(self.first), np.array(self.last)
        inward = np.minimum(-by, 0.5 * (high - low - SMALLEST))
        return self._between((low + inward).tolist(), (high - inward).tolist())

    def with_handle_at(self, handle: Place, to: Place) -> Self:
        """The box with the faces that a handle lies on moved to a position; none becomes too thin."""
        low, high = [*self.first], [*self.last]
        for axis, (at, end) in enumerate(zip(handle, to, strict=True)):
            if abs(at - low[axis]) <= _SAME:
                low[axis] = _off(end, high[axis])
            elif abs(at - high[axis]) <= _SAME:
                high[axis] = _off(end, low[axis])
        return self._between(low, high)

    def distance(self, position: Place) -> float:
        """Distance of a position from the nearest face [voxels]."""
        beside = [max(low - at, at - high) for low, at, high in zip(self.first, position, self.last, strict=True)]
        return math.hypot(*(max(off, 0.0) for off in beside)) if max(beside) > 0.0 else -max(beside)

    def encloses(self, position: Place) -> bool:
        """Whether a position lies inside."""
        return all(low <= at <= high for low, at, high in zip(self.first, position, self.last, strict=True))

    def _between(self, first: Sequence[float], last: Sequence[float]) -> Self:
        return replace(self, first=tuple(first), last=tuple(last))  # type: ignore[type-var]


def _off(end: float, other: float) -> float:
    """The place of a face, at least the smallest side away from the opposite one."""
    return end if abs(end - other) >= SMALLEST else other + math.copysign(SMALLEST, end - other)


@dataclass(frozen=True, slots=True)
class Box(Cuboid):
    """Particles on the faces of a box."""

    title: ClassVar[str] = "box"

    first: Voxel
    last: Voxel

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 3)."""
        return volume_starts.box(_three(self.first), _three(self.last), self.apart)

    @property
    def apart(self) -> float:
        """Distance between particles [voxels]: larger on a large box."""
        down, along, across = map(operator.sub, self.last, self.first)
        area = 2.0 * (down * along + along * across + across * down)
        return max(_APART, math.sqrt(area / _MOST))


@dataclass(frozen=True, slots=True)
class BoxRegion(Cuboid):
    """A region of interest in a volume, a box that particles do not leave."""

    title: ClassVar[str] = "region of interest"

    first: Voxel
    last: Voxel

    @property
    def limit(self) -> Pair:
        """It as the engine takes it."""
        return _three(self.first), _three(self.last)

    def encloses(self, position: Place) -> bool:
        """Always false: a region is selected at its faces only, since other shapes lie inside it."""
        return False


def _three(values: Voxel) -> tuple[float, float, float]:
    plane, row, col = values
    return plane, row, col
