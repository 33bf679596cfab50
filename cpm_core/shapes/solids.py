"""Boxes in a volume: particles on their faces, or a region of interest."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from typing import ClassVar, Self

import numpy as np

from cpm_core.image.image import Image
from cpm_core.image.volume_regions import Pair
from cpm_core.model.volume import starts as volume_starts
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Array, Place, Sides, Voxel, frozen
from cpm_core.shapes.areas import OnStrongEdges, Spaced, find_strong_pixels, finest_spacing, place_evenly
from cpm_core.shapes.ellipse import Round
from cpm_core.shapes.path import LARGEST_SIZE, WithoutOutline, check_number

MIN_BOX_SIDE = 1.0
"""Least side of a box [voxels], and radius of a sphere [sides of the smallest voxel]."""

_MIN_FACE_SPACING = 2.0
"""Least distance between particles on the faces [voxels]."""

_MAX_FACE_PARTICLES = 10_000
"""Approximate number of particles on a large box."""

_ON_FACE_DISTANCE = 1e-6
"""Distance within which a handle lies on a face [voxels]."""

_BOX_CORNERS = np.array(list(product((False, True), repeat=3)))
"""Whether each corner of a box lies on the last face across each axis, shape (8, 3)."""


def relative_sides(spacing: Sequence[float]) -> Sides:
    """Return the sides of a voxel relative to the smallest of them."""
    return tuple(side / min(spacing) for side in spacing)


@frozen
class Cuboid(WithoutOutline):
    """Box whose faces lie across the axes of the volume.

    Attributes
    ----------
    first, last : tuple of float
        The corners next to the first and to the last voxel of the volume, (plane, row, col) [voxels].
    """

    first: Voxel
    last: Voxel

    def __post_init__(self) -> None:
        low, high = np.sort([self.first, self.last], axis=0).tolist()
        if not all(math.isfinite(end) and abs(end) <= LARGEST_SIZE for end in (*low, *high)):
            raise ValueError(f"the corners of the box are {self.first} and {self.last} but must be in the volume.")
        if min(map(operator.sub, high, low)) < MIN_BOX_SIDE - _ON_FACE_DISTANCE:
            raise ValueError(
                f"the corners of the box are {self.first} and {self.last} but must be a voxel apart along every axis."
            )
        object.__setattr__(self, "first", tuple(low))
        object.__setattr__(self, "last", tuple(high))

    @property
    def center(self) -> Voxel:
        """Center (plane, row, col) [voxels]."""
        return tuple(0.5 * (low + high) for low, high in zip(self.first, self.last, strict=True))

    @property
    def outline(self) -> Array:
        """Corners of the box, shape (8, 3)."""
        return np.where(_BOX_CORNERS, self.last, self.first)

    def translated(self, offset: Place) -> Self:
        """Return the box displaced along each axis."""
        return self._with_corners(*polyline.translate_path((self.first, self.last), offset))

    def resized_by(self, by: float) -> Self:
        """Return the box with each face moved outward."""
        low, high = np.array(self.first), np.array(self.last)
        inward = np.minimum(-by, 0.5 * (high - low - MIN_BOX_SIDE))
        return self._with_corners((low + inward).tolist(), (high - inward).tolist())

    def with_handle_at(self, handle: Place, to: Place) -> Self:
        """Return the box with the faces of a handle moved to a position; it never becomes too thin."""
        low, high = [*self.first], [*self.last]
        for axis, (at, end) in enumerate(zip(handle, to, strict=True)):
            if abs(at - low[axis]) <= _ON_FACE_DISTANCE:
                low[axis] = _keep_apart(end, high[axis])
            elif abs(at - high[axis]) <= _ON_FACE_DISTANCE:
                high[axis] = _keep_apart(end, low[axis])
        return self._with_corners(low, high)

    def distance_to(self, position: Place) -> float:
        """Measure the distance of a position from the nearest face [voxels]."""
        beside = [max(low - at, at - high) for low, at, high in zip(self.first, position, self.last, strict=True)]
        return math.hypot(*(max(off, 0.0) for off in beside)) if max(beside) > 0.0 else -max(beside)

    def encloses(self, position: Place) -> bool:
        """Return whether a position lies inside."""
        return all(low <= at <= high for low, at, high in zip(self.first, position, self.last, strict=True))

    def _with_corners(self, first: Sequence[float], last: Sequence[float]) -> Self:
        return replace(self, first=tuple(first), last=tuple(last))


def _keep_apart(end: float, other: float) -> float:
    """Keep the place of a face at least the smallest side away from the opposite one."""
    return end if abs(end - other) >= MIN_BOX_SIDE else other + math.copysign(MIN_BOX_SIDE, end - other)


@frozen
class Box(Cuboid):
    """Particles on the faces of a box."""

    title: ClassVar[str] = "box"

    def seeds(self) -> Array:
        """Return the positions of the particles, shape (N, 3)."""
        return volume_starts.seeds_on_box(self.first, self.last, self.particle_spacing)

    @property
    def particle_spacing(self) -> float:
        """Distance between particles [voxels]: larger on a large box."""
        down, along, across = map(operator.sub, self.last, self.first)
        area = 2.0 * (down * along + along * across + across * down)
        return max(_MIN_FACE_SPACING, math.sqrt(area / _MAX_FACE_PARTICLES))


@frozen
class BoxRegion(Cuboid):
    """Region of interest in a volume, a box that particles do not leave."""

    title: ClassVar[str] = "region of interest"

    @property
    def limit(self) -> Pair:
        """Limit as the engine takes it."""
        return self.first, self.last

    def encloses(self, position: Place) -> bool:
        """Return False: a region is selected at its faces only, since other shapes lie inside it."""
        return False


@frozen
class BoxGrid(Spaced, Cuboid):
    """Particles spread evenly in a box.

    Attributes
    ----------
    first, last : tuple of float
        The corners next to the first and to the last voxel of the volume, (plane, row, col) [voxels].
    spacing : float
        Distance between particles along each axis, in sides of the smallest voxel.
    sides : tuple of float
        Sides of a voxel in the smallest of them.
    """

    sides: Voxel = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        for side in self.sides:
            check_number("sides", side, 1e-3, 1e3)
        super().__post_init__()

    @classmethod
    def from_corners(cls, one: Voxel, other: Voxel, spacing: Sides) -> BoxGrid:
        """Build a grid between two corners of a volume with this voxel size along each axis, no finer than allowed."""
        sides = relative_sides(spacing)
        lengths = [abs(b - a) * side for a, b, side in zip(one, other, sides, strict=True)]
        return cls(one, other, max(8.0, finest_spacing(lengths)), sides)

    def seeds(self) -> Array:
        """Return the positions of the particles, shape (N, 3), centered in the box."""
        return place_evenly(self._lengths, self.spacing) / np.array(self.sides) + self.first

    @property
    def _lengths(self) -> list[float]:
        """Lengths of the box along the axes, in sides of the smallest voxel."""
        return [(b - a) * side for a, b, side in zip(self.first, self.last, self.sides, strict=True)]


@frozen
class BoxThreshold(OnStrongEdges, Cuboid):
    """Particles where edges are strong, in a box; their positions depend on the volume.

    Attributes
    ----------
    first, last : tuple of float
        The corners next to the first and to the last voxel of the volume, (plane, row, col) [voxels].
    fraction : float
        Fraction of the largest edge strength in the box above which a voxel gets a particle.
    """

    def seeds_on(self, _image: Image, _channel: str, find_strength: Callable[[], Array]) -> Array:
        """Return the positions of the particles in a volume, shape (N, 3); see `Everywhere.seeds_on`."""
        return find_strong_pixels(find_strength(), self.outline, self.fraction)


@frozen
class Sphere(Round, WithoutOutline):
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
    def from_voxel_size(cls, center: Voxel, radius: float, spacing: Sides) -> Sphere:
        """Build a sphere that is round in a volume with this voxel size along each axis."""
        return cls(center, radius, relative_sides(spacing))

    def seeds(self) -> Array:
        """Return the positions of the particles, shape (N, 3)."""
        return volume_starts.sphere(self.center, self.radius, voxel_size=self.sides)

    def distance_from_center(self, position: Place) -> float:
        """Measure the distance of a position from the center, in sides of the smallest voxel."""
        offsets = map(operator.sub, position, self.center)
        return math.hypot(*map(operator.mul, offsets, self.sides))
