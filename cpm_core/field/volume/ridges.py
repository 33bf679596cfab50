"""The ridges of the edge map of a volume: where surfaces run, and which of them are connected by edges."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.interpolation import normal_at
from cpm_core.field.volume.surface_force import is_ridge
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.numerics.vectors import Vector, dot, length, set_row

_BESIDE = 1.0
"""Distance along the normal at which the edge must not be stronger, to either side [units]."""

_WORTH_A_THREAD = 5_000
"""Voxels from which a second thread makes the search faster."""


class Ridges(NamedTuple):
    """Voxels on the ridges of an edge map where it is at or above its floor.

    Attributes
    ----------
    place : ndarray, shape (M, 3)
        Their positions [units].
    normal : ndarray, shape (M, 3)
        Normals of the surface there.
    strength : ndarray, shape (M,)
        Edge strength.
    component : ndarray of int64, shape (M,)
        Number of the connected part of the edge map, from 0.
    """

    place: Array
    normal: Array
    strength: Array
    component: Index

    def where(self, index: Index) -> Ridges:
        """Those with the given indices, in this order."""
        return Ridges(self.place[index], self.normal[index], self.strength[index], self.component[index])


def ridges_of(smoothed: Single, edges: Single, pitch: Vector, floor: float, turn: float) -> Ridges:
    """All ridges of the edge map of a smoothed volume.

    A voxel is connected with those of the 26 around it that have a normal like its own: the scalar product is at least
    `turn`, so that walls of two objects that nearly touch each other stay apart.
    """
    least = np.float32(floor)
    count = int(np.count_nonzero(edges >= least))
    voxels, component = np.empty((count, 3), np.int32), np.empty(count, np.int32)
    _flood(smoothed, edges, pitch, least, turn, voxels, component)
    place = voxels * np.array(pitch)
    normal, ridge = np.empty((count, 3)), np.empty(count, np.bool_)
    share(partial(_test, smoothed, edges, pitch, place, normal, ridge), count, _WORTH_A_THREAD)
    found = voxels[ridge]
    strength = edges[tuple(found.T)].astype(float)
    return Ridges(place[ridge], normal[ridge], strength, component[ridge].astype(np.int64))


@compiled
def _flood(
    smoothed: Single,
    edges: Single,
    pitch: Vector,
    floor: np.float32,
    turn: float,
    voxels: NDArray[np.int32],
    component: NDArray[np.int32],
) -> None:
    """List the voxels at or above a floor, one connected part after the other."""
    planes, rows, cols = edges.shape
    seen = np.zeros(edges.shape, np.bool_)
    begin, end, number = 0, 0, 0
    for i in range(planes):
        for j in range(rows):
            for k in range(cols):
                if edges[i, j, k] >= floor and not seen[i, j, k]:
                    seen[i, j, k] = True
                    voxels[end, 0], voxels[end, 1], voxels[end, 2] = i, j, k
                    component[end] = number
                    end += 1
                    while begin < end:
                        end = _spread(smoothed, edges, pitch, floor, turn, seen, voxels, component, begin, end)
                        begin += 1
                    number += 1


@compiled
def _spread(
    smoothed: Single,
    edges: Single,
    pitch: Vector,
    floor: np.float32,
    turn: float,
    seen: Mask,
    voxels: NDArray[np.int32],
    component: NDArray[np.int32],
    begin: int,
    end: int,
) -> int:
    """Add the neighbors of a voxel that have not been listed; return how many are listed then."""
    i, j, k = voxels[begin, 0], voxels[begin, 1], voxels[begin, 2]
    own = _slope(smoothed, pitch, i, j, k)
    for u in range(max(i - 1, 0), min(i + 2, edges.shape[0])):
        for v in range(max(j - 1, 0), min(j + 2, edges.shape[1])):
            for w in range(max(k - 1, 0), min(k + 2, edges.shape[2])):
                if edges[u, v, w] >= floor and not seen[u, v, w] and _is_like(smoothed, pitch, own, turn, u, v, w):
                    seen[u, v, w] = True
                    voxels[end, 0], voxels[end, 1], voxels[end, 2] = u, v, w
                    component[end] = component[begin]
                    end += 1
    return end


@compiled
def _slope(smoothed: Single, pitch: Vector, i: int, j: int, k: int) -> Vector:
    """Slope of the smoothed volume at a voxel."""
    planes, rows, cols = smoothed.shape
    z = smoothed[min(i + 1, planes - 1), j, k] - smoothed[max(i - 1, 0), j, k]
    y = smoothed[i, min(j + 1, rows - 1), k] - smoothed[i, max(j - 1, 0), k]
    x = smoothed[i, j, min(k + 1, cols - 1)] - smoothed[i, j, max(k - 1, 0)]
    return z / pitch[0], y / pitch[1], x / pitch[2]


@compiled
def _is_like(smoothed: Single, pitch: Vector, own: Vector, turn: float, i: int, j: int, k: int) -> bool:
    """Whether the normal of a voxel is like that of the slope `own`."""
    if turn <= -1.0:
        return True
    other = _slope(smoothed, pitch, i, j, k)
    return bool(dot(own, other) >= turn * length(own) * length(other))


@compiled
def _test(
    smoothed: Single,
    edges: Single,
    pitch: Vector,
    place: Array,
    normal: Array,
    ridge: Mask,
    first: int,
    last: int,
) -> None:
    """Normal at each voxel, and whether it is on a ridge."""
    for q in range(first, last):
        here = (place[q, 0], place[q, 1], place[q, 2])
        set_row(normal, q, normal_at(smoothed, pitch, here))
        ridge[q] = is_ridge(smoothed, edges, pitch, here, _BESIDE)
