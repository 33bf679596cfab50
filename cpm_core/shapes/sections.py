"""What a slice of a volume shows of a shape: its section, a shape in the plane of the slice."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from cpm_core.numerics.types import Array, Position
from cpm_core.shapes import Points, Shape, Sphere
from cpm_core.shapes.ellipse import Ellipse
from cpm_core.shapes.path import SMALLEST

NEAR = 1.0
"""Distance from a slice up to which it shows a point, in sides of the smallest voxel."""


@dataclass(frozen=True, slots=True)
class SphereSection(Ellipse):
    """Where a slice cuts a sphere: round in space, an ellipse in voxels that are no cubes."""

    particles: Array = field(default_factory=lambda: np.empty((0, 2)), compare=False)

    def seeds(self) -> Array:
        """The particles of the sphere that lie near the slice, shape (N, 2)."""
        return self.particles

    def handles(self) -> tuple[Position, ...]:
        """The four ends of the axes, for resizing."""
        (row, col), (along, across) = self.center, self.radii
        return ((row, col + along), (row + across, col), (row, col - along), (row - across, col))


def section(shape: Shape, axis: int, index: float) -> Shape | None:
    """The section of a shape by a slice; None where the slice does not show it.

    `index` is the place of the slice along `axis` [voxels]. A shape in a volume that has no section of its own kind is
    not shown; shapes in the plane belong to no volume.
    """
    if isinstance(shape, Sphere):
        return _of_sphere(shape, axis, index)
    if isinstance(shape, Points) and len(shape.positions[0]) == 3:
        near = tuple(place[:axis] + place[axis + 1 :] for place in shape.positions if abs(place[axis] - index) <= NEAR)
        return Points(near) if near else None
    return None


def _of_sphere(sphere: Sphere, axis: int, index: float) -> SphereSection | None:
    off = (index - sphere.center[axis]) * sphere.sides[axis]
    if abs(off) >= sphere.radius:
        return None
    radius = math.sqrt(sphere.radius**2 - off**2)
    center, (down, right) = (values[:axis] + values[axis + 1 :] for values in (sphere.center, sphere.sides))
    seeds = sphere.seeds()
    near = np.abs(seeds[:, axis] - index) * sphere.sides[axis] <= NEAR
    return SphereSection(
        center,
        (max(radius / right, SMALLEST), max(radius / down, SMALLEST)),
        particles=np.delete(seeds[near], axis, axis=1),
    )
