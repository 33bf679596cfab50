"""The walls of a volume: painted voxels, what is outside the regions of interest, and planes, which nothing crosses.

Whether a move crosses a wall is decided exactly, by the straight line between its ends; touching counts. A particle is
never in touch with a wall, so that no speed is too high and no wall too thin. Painted voxels that meet along an edge or
at a corner are a wall without a gap, since a line between them touches both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cpm_core.image.pyramid import to_image
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parts import Parts, parts_of
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.numerics.vectors import Vector, row_of

OFF = 1e-6
"""Distance from a wall within which a position touches it [voxels]."""

_CLOSED = -1
"""The room of a position in a wall."""


@dataclass(frozen=True, eq=False)
class Walls:
    """What no particle crosses, in a volume at one of its scales.

    Attributes
    ----------
    closed : ndarray of bool, shape (P, R, C)
        Voxels of the volume, at its full size, that no particle enters.
    planes : ndarray, shape (K, 4)
        Unit vector across each plane, and its distance from the origin along it [voxels].
    size : ndarray, shape (3,)
        Voxels of the volume in one unit of the positions, along each axis.
    first : ndarray, shape (3,)
        The place of the origin of the positions [voxels].
    """

    closed: Mask
    planes: Array
    size: Array
    first: Array

    def at_scale(self, scale: int, pitch: Vector) -> Walls:
        """The same walls for positions at a scale, in units in which a voxel has these sides."""
        ends = to_image(np.array([[0.0] * 3, [1.0] * 3]), scale, self.closed.shape)
        return replace(self, size=(ends[1] - ends[0]) / np.array(pitch), first=ends[0])

    def voxels(self, positions: Array) -> Array:
        """Positions of the scale, shape (N, 3), in voxels of the volume."""
        return np.asarray(positions * self.size + self.first)

    def crossed(self, start: Array, end: Array) -> Mask:
        """Which of the straight moves between positions of the scale, shapes (N, 3), cross or touch a wall."""
        out = np.zeros(len(start), np.bool_)
        if len(start):
            _crossed(self.closed, self.planes, self.voxels(start), self.voxels(end), out)
        return out

    def rooms(self, positions: Array) -> Index:
        """Number of the room that each position of the scale, shape (N, 3), lies in; -1 in a wall.

        No move leads from one room to another. Parts of a volume that are connected, but not straight, are one room.
        """
        places = self.voxels(positions)
        voxels = np.clip(np.rint(places).astype(np.int64), 0, np.array(self.closed.shape) - 1)
        part = self._open.part_at(voxels)
        sides = (signed_distances(self.planes, places) > 0.0) @ (1 << np.arange(len(self.planes)))
        return np.asarray(np.where(part < 0, _CLOSED, (part << len(self.planes)) + sides))

    def shut(self, shape: tuple[int, ...], pitch: Vector, positions: Array) -> Mask:
        """Which voxels of the scale, of this shape, are in a wall or in a room without any of the positions."""
        found = self.filled(shape, pitch)
        rooms = np.unique(self.rooms(positions))
        for plane, part in enumerate(found):
            part[~np.isin(self.rooms(_centers(plane, shape, pitch)), rooms).reshape(part.shape)] = True
        return found

    def filled(self, shape: tuple[int, ...], pitch: Vector) -> Mask:
        """Which voxels of the scale, of this shape, are in a wall: their centers, or in planes any part of them."""
        found = np.empty(shape, np.bool_)
        thick = 0.5 * np.abs(self.planes[:, :3]) @ np.abs(self.size * pitch)
        last = np.array(self.closed.shape) - 1
        for plane, part in enumerate(found):
            places = self.voxels(_centers(plane, shape, pitch))
            closed = self.closed[tuple(np.clip(np.rint(places).astype(np.int64), 0, last).T)]
            touched = (np.abs(signed_distances(self.planes, places)) <= thick).any(axis=1)
            part[:] = (closed | touched).reshape(part.shape)
        return found

    @cached_property
    def _open(self) -> Parts:
        """The parts of what is not closed; voxels with a common face are connected."""
        return parts_of(~self.closed, corners=False)


def _centers(plane: int, shape: tuple[int, ...], pitch: Vector) -> Array:
    """Centers of the voxels in one plane of a volume of this shape, shape (N, 3)."""
    return np.asarray((np.indices((1, *shape[1:])).reshape(3, -1).T + np.array([plane, 0, 0])) * np.array(pitch))


def signed_distances(planes: Array, places: Array) -> Array:
    """Distance of places, shape (N, 3), from each plane, shape (N, K) [voxels]."""
    return np.asarray(places @ planes[:, :3].T - planes[:, 3])


@compiled
def _crossed(closed: Mask, planes: Array, start: Array, end: Array, out: Mask) -> None:
    for i in range(len(start)):
        a, b = row_of(start, i), row_of(end, i)
        out[i] = _meets_plane(planes, a, b) or _meets_voxel(closed, a, b)


@compiled
def _meets_plane(planes: Array, a: Vector, b: Vector) -> bool:
    """Whether a straight line meets a plane."""
    for k in range(len(planes)):
        here = a[0] * planes[k, 0] + a[1] * planes[k, 1] + a[2] * planes[k, 2] - planes[k, 3]
        there = b[0] * planes[k, 0] + b[1] * planes[k, 1] + b[2] * planes[k, 2] - planes[k, 3]
        if min(abs(here), abs(there)) <= OFF or (here > 0.0) != (there > 0.0):
            return True
    return False


@compiled
def _meets_voxel(closed: Mask, a: Vector, b: Vector) -> bool:
    """Whether a straight line meets a closed voxel."""
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for axis in range(3):
        last = closed.shape[axis] - 1
        low[axis] = min(max(int(np.floor(min(a[axis], b[axis]) + 0.5 - OFF)), 0), last)
        high[axis] = min(max(int(np.floor(max(a[axis], b[axis]) + 0.5 + OFF)), 0), last)
    for i in range(low[0], high[0] + 1):
        for j in range(low[1], high[1] + 1):
            for k in range(low[2], high[2] + 1):
                if closed[i, j, k] and _enters(a, b, (float(i), float(j), float(k))):
                    return True
    return False


@compiled
def _enters(a: Vector, b: Vector, center: Vector) -> bool:
    """Whether a straight line meets the cube around a voxel."""
    begin, end = 0.0, 1.0
    for axis in range(3):
        way, off = b[axis] - a[axis], a[axis] - center[axis]
        if abs(way) < 1e-300:
            if abs(off) > 0.5 + OFF:
                return False
            continue
        one, other = (-0.5 - OFF - off) / way, (0.5 + OFF - off) / way
        begin, end = max(begin, min(one, other)), min(end, max(one, other))
    return begin <= end
