"""Particles on a sphere in a volume."""

from __future__ import annotations

import math
import operator
from dataclasses import dataclass, replace
from typing import ClassVar

from cpm_core.model.volume import starts as volume_starts
from cpm_core.numerics.types import Array, Place, Voxel
from cpm_core.shapes.path import LARGEST, WithoutOutline, check_number

SMALLEST = 1.0
"""Least radius of a sphere that is drawn, in sides of the smallest voxel."""


@dataclass(frozen=True, slots=True)
class Sphere(WithoutOutline):
    """Particles on a sphere, evenly spread.

    Attributes
    ----------
    center : tuple of float
        (plane, row, col) [voxels].
    radius : float
        Radius in sides of the smallest voxel, from 0.5 to 100,000.
    sides : tuple of float
        Sides of a voxel in the smallest of them: a sphere is round in space, not in voxels.
    """

    title: ClassVar[str] = "sphere"

    center: Voxel
    radius: float
    sides: Voxel = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        if len(self.center) != 3 or len(self.sides) != 3:
            raise ValueError(f"center and sides have {len(self.center)} and {len(self.sides)} numbers but need three.")
        check_number("radius", self.radius)
        for side in self.sides:
            check_number("sides", side, 1e-3, 1e3)

    @classmethod
    def round(cls, center: Voxel, radius: float, spacing: tuple[float, ...]) -> Sphere:
        """A sphere that is round in a volume with this size of a voxel along each axis."""
        return cls(center, radius, tuple(side / min(spacing) for side in spacing))

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 3)."""
        return volume_starts.sphere(_three(self.center), self.radius, spacing=_three(self.sides))

    def moved(self, by: Place) -> Sphere:
        """The same sphere displaced by so much along each axis [voxels]."""
        return replace(self, center=tuple(map(operator.add, self.center, by)))

    def resized(self, by: float) -> Sphere:
        """The sphere with another radius."""
        return self._with_radius(self.radius + by)

    def with_handle_at(self, handle: Place, to: Place) -> Sphere:
        """The sphere with the same center through a position, for any handle."""
        return self._with_radius(self.away(to))

    def away(self, position: Place) -> float:
        """Distance of a position from the center, in sides of the smallest voxel."""
        offsets = map(operator.sub, position, self.center)
        return math.hypot(*map(operator.mul, offsets, self.sides))

    def distance(self, position: Place) -> float:
        """Distance of a position from the surface, in sides of the smallest voxel."""
        return abs(self.away(position) - self.radius)

    def encloses(self, position: Place) -> bool:
        """Whether a position lies inside."""
        return self.away(position) <= self.radius

    def _with_radius(self, radius: float) -> Sphere:
        return replace(self, radius=min(max(radius, SMALLEST), LARGEST))


def _three(values: Voxel) -> tuple[float, float, float]:
    plane, row, col = values
    return plane, row, col
