"""Boxes in a volume that are filled with particles: evenly, or where edges are strong."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from cpm_core.numerics.types import Array, Voxel
from cpm_core.shapes.areas import COARSEST, FINEST, HIGHEST, LOWEST, MOST_PLACES, STEP, centered_along
from cpm_core.shapes.path import check_number
from cpm_core.shapes.space.box import Cuboid


@dataclass(frozen=True, slots=True)
class BoxGrid(Cuboid):
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

    title: ClassVar[str] = "grid"

    first: Voxel
    last: Voxel
    spacing: float = 8.0
    sides: Voxel = (1.0, 1.0, 1.0)

    def __post_init__(self) -> None:
        Cuboid.__post_init__(self)
        check_number("spacing", self.spacing)
        for side in self.sides:
            check_number("sides", side, 1e-3, 1e3)
        places = math.prod(length / self.spacing + 1.0 for length in self._lengths)
        if not places <= MOST_PLACES:
            raise ValueError(
                f"spacing is {self.spacing:g}, which gives {places:.3g} particles in the box, but there may be "
                f"{MOST_PLACES} at most: make the spacing wider or the box smaller."
            )

    @classmethod
    def between(cls, one: Voxel, other: Voxel, spacing: tuple[float, ...]) -> BoxGrid:
        """A grid between two corners of a volume with this size of a voxel along each axis, no finer than allowed."""
        sides = tuple(side / min(spacing) for side in spacing)
        lengths = [abs(b - a) * side for a, b, side in zip(one, other, sides, strict=True)]
        return cls(one, other, max(8.0, _finest(lengths)), sides)

    def seeds(self) -> Array:
        """Positions of the particles, shape (N, 3), centered in the box."""
        along = [centered_along(length, self.spacing) for length in self._lengths]
        places = np.stack(np.meshgrid(*along, indexing="ij"), axis=-1).reshape(-1, 3)
        return np.asarray(places / np.array(self.sides) + self.first)

    def resized(self, by: float) -> BoxGrid:
        """The same box with the spacing changed by so much."""
        finest = max(FINEST, _finest(self._lengths))
        return replace(self, spacing=min(max(self.spacing + by, finest), max(COARSEST, finest)))

    @property
    def _lengths(self) -> Sequence[float]:
        """Lengths of the box along the axes, in sides of the smallest voxel."""
        return [(b - a) * side for a, b, side in zip(self.first, self.last, self.sides, strict=True)]


def _finest(lengths: Sequence[float]) -> int:
    """The least spacing at which a box of these lengths has no more particles than are allowed."""
    side: float = (2.0 * math.prod(length + 1.0 for length in lengths) / MOST_PLACES) ** (1.0 / 3.0)
    return math.ceil(side)


@dataclass(frozen=True, slots=True)
class BoxThreshold(Cuboid):
    """Particles where edges are strong, in a box; their positions depend on the volume.

    Attributes
    ----------
    first, last : tuple of float
        The corners next to the first and to the last voxel of the volume, (plane, row, col) [voxels].
    fraction : float
        Fraction of the largest edge strength in the box above which a voxel gets a particle.
    """

    title: ClassVar[str] = "threshold"
    follows_smoothing: ClassVar[bool] = True

    first: Voxel
    last: Voxel
    fraction: float = 0.3

    def __post_init__(self) -> None:
        Cuboid.__post_init__(self)
        check_number("fraction", self.fraction, 0.0, 1.0)

    def seeds_within(self, strength: Callable[[], Array]) -> Array:
        """Positions of the particles in a volume, shape (N, 3), given the edge strength of its voxels."""
        whole = strength()
        low = np.clip(np.ceil(self.first), 0, whole.shape).astype(int)
        high = np.clip(np.floor(self.last) + 1, low, whole.shape).astype(int)
        inside = whole[tuple(slice(a, b) for a, b in zip(low, high, strict=True))]
        if not inside.size:
            return np.empty((0, 3))
        return np.asarray(np.argwhere(inside > self.fraction * inside.max()).astype(float) + low)

    def resized(self, by: float) -> BoxThreshold:
        """The same box with the threshold raised by so many steps of 0.02."""
        return replace(self, fraction=round(min(max(self.fraction + STEP * by, LOWEST), HIGHEST), 6))
