"""Fields of a volume for its slices: on a part of the voxels, as many as a view shows arrows or lines for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy

from app.model.volume.slices import Slice
from cpm_core.numerics import Array, Single
from cpm_core.shapes import sides_of

_MOST = 1 << 18
"""Voxels of which a force is kept, at most about so many: a view shows some hundred arrows."""

_MOST_VALUES = 1 << 24
"""Voxels of which a value is kept."""


@dataclass(frozen=True, eq=False, slots=True)
class SampledForce:
    """The force on every so manieth voxel, shape (3, P, R, C), in smallest sides of a voxel, and those sides."""

    force: Single
    step: int
    sides: tuple[float, ...]

    @classmethod
    def of(cls, force: Array, spacing: tuple[float, ...]) -> SampledForce:
        """That of a force on all voxels, of which nothing is kept."""
        step = _step(force[0].size, _MOST)
        return cls(force[:, ::step, ::step, ::step].astype(np.float32), step, sides_of(spacing))

    def slice_of(self, here: Slice, shape: tuple[int, ...]) -> Array:
        """The force along a slice of this shape, (2, H, W), as a displacement in its pixels."""
        places = np.insert(np.indices(shape) / self.step, here.axis, here.index / self.step, axis=0)
        along = [
            scipy.ndimage.map_coordinates(force, places, float, order=1, mode="nearest") / side
            for force, side in zip(here.within(tuple(self.force)), here.within(self.sides), strict=True)
        ]
        return np.stack(along)


@dataclass(frozen=True, eq=False, slots=True)
class SampledValues:
    """A value of every so manieth voxel, shape (P, R, C)."""

    values: Single
    step: int

    @classmethod
    def of(cls, values: Array) -> SampledValues:
        """Those of all voxels, of which nothing is kept."""
        step = _step(values.size, _MOST_VALUES)
        return cls(values[::step, ::step, ::step].astype(np.float32), step)

    def slice_of(self, here: Slice) -> Array:
        """The values of the nearest slice that there is."""
        planes = self.values.shape[here.axis]
        nearest = Slice(here.axis, min(round(here.index / self.step), planes - 1))
        return nearest.of(self.values).astype(float)


def _step(size: int, most: int) -> int:
    return max(1, int(np.ceil((size / most) ** (1.0 / 3.0))))
