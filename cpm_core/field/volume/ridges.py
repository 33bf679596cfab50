"""The ridges of the edge map of a volume: where surfaces run, and which of them are connected by edges."""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from cpm_core.field.interpolation import normal_at
from cpm_core.field.volume.surface_force import is_ridge
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask, Single
from cpm_core.numerics.vectors import Vector, set_row

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
    voxels = np.argwhere(edges >= np.float32(floor))
    count, component = len(voxels), _connected(smoothed, voxels, pitch, turn)
    place = voxels * np.array(pitch)
    normal, ridge = np.empty((count, 3)), np.empty(count, np.bool_)
    share(partial(_test, smoothed, edges, pitch, place, normal, ridge), count, _WORTH_A_THREAD)
    found = voxels[ridge]
    strength = edges[tuple(found.T)].astype(float)
    return Ridges(place[ridge], normal[ridge], strength, component[ridge].astype(np.int64))


def _connected(smoothed: Single, voxels: Index, pitch: Vector, turn: float) -> NDArray[np.int32]:
    """Number of the connected part of each of some voxels, shape (M, 3); see `ridges_of`."""
    number = np.full(np.array(smoothed.shape) + 2, -1, np.int32)
    number[tuple((voxels + 1).T)] = np.arange(len(voxels))
    last = np.array(smoothed.shape) - 1
    slope = np.empty((len(voxels), 3))
    for axis, step in enumerate(np.eye(3, dtype=int)):
        ahead, behind = np.minimum(voxels + step, last), np.maximum(voxels - step, 0)
        slope[:, axis] = (smoothed[tuple(ahead.T)] - smoothed[tuple(behind.T)]) / pitch[axis]
    size, pairs = np.linalg.norm(slope, axis=1), []
    for offset in list(np.ndindex(3, 3, 3))[:13]:  # the other half are the same pairs
        other = number[tuple((voxels + offset).T)]
        one = np.flatnonzero(other >= 0)
        other = other[one]
        like = np.einsum("ni,ni->n", slope[one], slope[other]) >= turn * size[one] * size[other]
        pairs.append(np.stack([one, other])[:, like | (turn <= -1.0)])
    joined, count = np.concatenate(pairs, axis=1), len(voxels)
    graph = scipy.sparse.coo_array((np.ones(joined.shape[1], np.bool_), tuple(joined)), (count, count))
    found: NDArray[np.int32] = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
    return found


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
