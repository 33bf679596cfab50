"""Cubes: the parts of a volume that the network looks at in slices, each brought to the same number of steps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.objects.prior.windows import BRIGHTEST, DARKEST, SAMPLES, SIDE

_FLAT = 1e-6
"""Range of gray levels, as a fraction of the largest, up to which a volume is even."""


@dataclass(frozen=True, eq=False)
class Cube:
    """A cube in a volume.

    Attributes
    ----------
    middle : ndarray, shape (3,)
        Its middle [smallest sides of a voxel].
    side : float
        Length of its sides, likewise; it may extend beyond the volume.
    """

    middle: Array
    side: float

    @property
    def scale(self) -> float:
        """Distance between its steps."""
        return self.side / SIDE

    @property
    def lines(self) -> list[Array]:
        """Positions of its steps along each axis, each of shape (SIDE,)."""
        return [middle + (np.arange(SIDE) - SIDE / 2) * self.scale for middle in self.middle.tolist()]

    def steps(self, places: Array) -> Array:
        """Places, shape (N, 3), in steps from its first one."""
        return (places - self.middle) / self.scale + SIDE / 2

    def places(self, steps: Array) -> Array:
        """The inverse of `steps`."""
        return (steps - SIDE / 2) * self.scale + self.middle

    def of(self, other: Cube, values: Single, beyond: float) -> Single:
        """The values of another cube in this one, trilinear; and what is beyond that."""
        lines = [(line - m) / other.scale + SIDE / 2 for line, m in zip(self.lines, other.middle, strict=True)]
        found = resampled(values, lines, (1.0, 1.0, 1.0))
        for axis, line in enumerate(lines):
            np.moveaxis(found, axis, 0)[(line < 0) | (line > SIDE - 1)] = beyond
        return found


@dataclass(frozen=True, eq=False)
class Grays:
    """A volume as the network sees it.

    Attributes
    ----------
    values : ndarray, shape (P, R, C)
        Gray levels.
    size : ndarray, shape (3,)
        Sides of a voxel; the smallest is 1.
    """

    values: Array
    size: Array

    def through(self, cube: Cube, across: dict[int, float] | None = None) -> Single:
        """Gray levels from 0 to 255 at the steps of a cube; of one slice for the place where it is `across` an axis."""
        lines = [np.array([across[axis]]) if across and axis in across else cube.lines[axis] for axis in range(3)]
        low, high = self._range
        voxels = [line / side for line, side in zip(lines, self.size.tolist(), strict=True)]
        factor = 255.0 / (high - low) if high - low > _FLAT * max(abs(low), abs(high)) else 0.0
        return (resampled(self.values, voxels, tuple(cube.scale / self.size)) - low) * factor

    def within(self, cube: Cube) -> Index:
        """For each axis the first and the last step of a cube in the volume, shape (3, 2)."""
        found = []
        for line, side, count in zip(cube.lines, self.size.tolist(), self.values.shape, strict=True):
            there = np.flatnonzero((line >= -0.5 * side) & (line <= (count - 0.5) * side))
            found.append((there[0], there[-1]) if len(there) else (0, 0))
        return np.array(found)

    @cached_property
    def extent(self) -> float:
        """Length of the longest side of the volume."""
        return float((self.size * self.values.shape).max())

    @cached_property
    def _range(self) -> tuple[float, ...]:
        step = max(int(np.cbrt(self.values.size / SAMPLES)), 1)
        return tuple(np.percentile(self.values[::step, ::step, ::step], [DARKEST, BRIGHTEST]).tolist())


def resampled(values: Array | Single | Mask, lines: list[Array], widths: tuple[float, ...]) -> Single:
    """Values at the crossings of lines along each axis [voxels]: means under a tent as wide as the steps are long.

    Beyond the border they are as at the border.
    """
    weights, box = [], []
    for line, width, count in zip(lines, widths, values.shape, strict=True):
        reach = max(width, 1.0)
        first = int(np.clip(np.floor(line[0] - reach), 0, count - 1))
        end = int(np.clip(np.ceil(line[-1] + reach) + 1, first + 1, count))
        near = np.clip(line, 0, count - 1)[:, None] - np.arange(first, end)
        tent = np.maximum(1.0 - np.abs(near) / reach, 0.0)
        weights.append((tent / tent.sum(axis=1, keepdims=True)).astype(np.float32))
        box.append(slice(first, end))
    found = values[tuple(box)].astype(np.float32)
    for axis in np.argsort([len(tent) / tent.shape[1] for tent in weights]).tolist():
        found = np.moveaxis(np.tensordot(weights[axis], found, (1, axis)), 0, axis)
    return np.ascontiguousarray(found)
