"""Shapes drawn in a slice of a volume that limit the particles in other slices as well."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from cpm_core.image.region import Region
from cpm_core.image.volume_regions import Extrusion
from cpm_core.numerics.types import Array, Line, Place, Position, frozen
from cpm_core.shapes.lines import Barrier, PolygonRegion
from cpm_core.shapes.path import WithoutOutline

_ON_CORNER_DISTANCE = 1e-6
"""Distance within which a handle is a corner [voxels]."""


@frozen
class Extruded(WithoutOutline):
    """Line in the slices across an axis, from one of them to another.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners along the two other axes of the volume, in their order [voxels].
    axis : int
        The axis across the slices.
    first, last : float
        Between which places along the axis it acts [voxels].
    """

    flat: ClassVar[type[PolygonRegion] | type[Barrier]]
    """Shape that a slice across the axis shows."""

    points: Line
    axis: int
    first: float
    last: float

    def __post_init__(self) -> None:
        self.flat(self.points)
        low, high = sorted((self.first, self.last))
        object.__setattr__(self, "first", low)
        object.__setattr__(self, "last", high)
        assert self.limit  # which checks the rest

    @property
    def limit(self) -> Extrusion:
        """Limit as the engine takes it."""
        return Extrusion(self.points, self.axis, self.first, self.last, closed=self.flat is PolygonRegion)

    @property
    def outline(self) -> Array:
        """The line in the middle of the range, shape (K, 3)."""
        return np.insert(self.flat(self.points).outline, self.axis, 0.5 * (self.first + self.last), axis=1)

    def translated(self, offset: Place) -> Self:
        """Return the shape displaced along each axis."""
        points = self.flat(self.points).translated(self.project_to_slice(offset)).points
        return self._with_range(points, self.first + offset[self.axis], self.last + offset[self.axis])

    def resized_by(self, by: float) -> Self:
        """Enlarge a closed line in its slices."""
        return self._with_range(self.flat(self.points).resized_by(by).points, self.first, self.last)

    def with_handle_at(self, handle: Place, to: Place) -> Self:
        """Return the shape with a corner moved in its slice, or with the nearer end of its range moved."""
        at, flat = self.project_to_slice(handle), self.flat(self.points)
        if handle[self.axis] == to[self.axis] and any(
            math.dist(at, corner) <= _ON_CORNER_DISTANCE for corner in self.points
        ):
            return self._with_range(flat.with_handle_at(at, self.project_to_slice(to)).points, self.first, self.last)
        end = to[self.axis]
        if abs(handle[self.axis] - self.first) <= abs(handle[self.axis] - self.last):
            return self._with_range(self.points, min(end, self.last), self.last)
        return self._with_range(self.points, self.first, max(end, self.first))

    def distance_to(self, position: Place) -> float:
        """Measure the distance of a position from the line through the slices [voxels]."""
        beyond = max(self.first - position[self.axis], position[self.axis] - self.last, 0.0)
        return math.hypot(self.flat(self.points).distance_to(self.project_to_slice(position)), beyond)

    def project_to_slice(self, place: Place) -> Position:
        """Project a place to the slices across the axis."""
        return place[: self.axis] + place[self.axis + 1 :]

    def _with_range(self, points: Line, first: float, last: float) -> Self:
        return replace(self, points=points, first=first, last=last)


@frozen
class PrismRegion(Extruded):
    """Region of interest in a volume: the inside of a line in a slice, through a range of slices."""

    title: ClassVar[str] = "region of interest"
    flat: ClassVar[type[PolygonRegion]] = PolygonRegion


@frozen
class Wall(Extruded):
    """A barrier in a volume: a line in a slice, through a range of slices, that particles do not cross."""

    title: ClassVar[str] = "barrier"
    flat: ClassVar[type[Barrier]] = Barrier


@frozen
class Enclosed(WithoutOutline):
    """Inside of a closed surface.

    Attributes
    ----------
    region : Region
        The voxels inside.
    """

    title: ClassVar[str]
    region: Region

    def __post_init__(self) -> None:
        if self.region.ndim != 3 or self.region.is_empty:
            raise ValueError(f"A {self.title} in a volume needs at least one voxel.")

    @property
    def limit(self) -> Region:
        """Limit as the engine takes it."""
        raise NotImplementedError

    @property
    def center(self) -> Place:
        """Middle of the bounding box, (plane, row, col) [voxels]."""
        return tuple(np.mean(self.region.bounds, axis=0).tolist())

    @property
    def outline(self) -> Array:
        """Corners of the triangles, shape (K, 3)."""
        return self.region.find_surface().vertices

    def translated(self, offset: Place) -> Self:
        """Return the shape displaced along each axis."""
        return replace(self, region=self.region.translated(offset))

    def distance_to(self, position: Place) -> float:
        """Measure the distance of a position from the nearest corner of a triangle [voxels]."""
        return math.sqrt(float(((self.outline - position) ** 2).sum(axis=1).min()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.region.find_surface()!r})"


@dataclass(frozen=True, repr=False)
class EnclosedRegion(Enclosed):
    """A region of interest in a volume: the voxels inside a surface."""

    title: ClassVar[str] = "region of interest"

    @property
    def limit(self) -> Region:
        """Voxels whose centers lie inside."""
        return self.region


@dataclass(frozen=True, repr=False)
class EnclosingWall(Enclosed):
    """A barrier in a volume: the outermost voxels inside a surface, which no particle enters."""

    title: ClassVar[str] = "barrier"

    @property
    def limit(self) -> Region:
        """Voxels inside that share a face with one outside."""
        return self.region.shell
