"""What a closed surface encloses in a volume, as a limit of particles: an object that was found before."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Self

from cpm_core.contours.surface.packing import PackedSurface
from cpm_core.image.volume_regions import Voxels
from cpm_core.numerics.types import Array, Place
from cpm_core.shapes.path import WithoutOutline


class Enclosed(WithoutOutline):
    """The inside of a closed surface. Subclasses are frozen dataclasses.

    Attributes
    ----------
    surface : PackedSurface
        The surface.
    """

    __slots__ = ()

    surface: PackedSurface

    @property
    def limit(self) -> Voxels:
        """It as the engine takes it."""
        raise NotImplementedError

    @property
    def center(self) -> Place:
        """The middle of the box around it, (plane, row, col) [voxels]."""
        vertices = self.surface.surface.vertices
        plane, row, col = (0.5 * (vertices.min(axis=0) + vertices.max(axis=0))).tolist()
        return plane, row, col

    @property
    def outline(self) -> Array:
        """The corners of its triangles, shape (K, 3)."""
        return self.surface.surface.vertices

    def moved(self, by: Place) -> Self:
        """The same shape displaced by so much along each axis."""
        return replace(self, surface=self.surface.moved(by))  # type: ignore[type-var]

    def distance(self, position: Place) -> float:
        """Distance of a position from the nearest corner of a triangle [voxels]."""
        return math.sqrt(float(((self.outline - position) ** 2).sum(axis=1).min()))

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.surface.surface!r})"


@dataclass(frozen=True, slots=True, repr=False)
class EnclosedRegion(Enclosed):
    """A region of interest in a volume: the voxels inside a surface."""

    title: ClassVar[str] = "region of interest"

    surface: PackedSurface

    @property
    def limit(self) -> Voxels:
        """The voxels whose centers lie inside."""
        return self.surface.voxels


@dataclass(frozen=True, slots=True, repr=False)
class EnclosingWall(Enclosed):
    """A barrier in a volume: the outermost voxels inside a surface, which no particle enters."""

    title: ClassVar[str] = "barrier"

    surface: PackedSurface

    @property
    def limit(self) -> Voxels:
        """The voxels inside that have a side in common with one outside."""
        return self.surface.shell
