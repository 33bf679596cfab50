"""Lines of voxels as chains between junctions and ends."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.types import Array, Index, Mask

_AROUND = np.array([step for step in product((-1, 0, 1), repeat=3) if any(step)])


class Chain(NamedTuple):
    """A line of voxels.

    Attributes
    ----------
    points : ndarray, shape (N, 3)
        Places along it; at a junction of several voxels their mean.
    own : ndarray of int64, shape (M, 3)
        Voxels that belong to no junction.
    nodes : tuple of int
        Numbers of the places at its ends.
    free_end : int
        0 or 1 when that end lies in the open and the other at a junction, else -1.
    """

    points: Array
    own: Index
    nodes: tuple[int, int]
    free_end: int

    @property
    def free(self) -> bool:
        """Whether it hangs at a junction with its other end in the open."""
        return self.free_end >= 0


def chains_of(lines: Mask) -> list[Chain]:
    """Chains of a mask of lines one voxel thick, whose outermost voxels are False."""
    voxels = np.argwhere(lines)
    number = np.full(lines.shape, -1, np.int64)
    number[tuple(voxels.T)] = np.arange(len(voxels))
    near = number[tuple((voxels[:, None] + _AROUND).transpose(2, 0, 1))]
    degree = (near >= 0).sum(1)
    crowded = np.zeros(lines.shape, bool)
    crowded[tuple(voxels[degree > 2].T)] = True
    labels, count = scipy.ndimage.label(crowded, np.ones((3, 3, 3)))
    junction = labels[tuple(voxels.T)] - 1  # -1 for voxels of chains
    centers = np.array([voxels[junction == k].mean(0) for k in range(count)]).reshape(-1, 3)
    neighbors = [row[row >= 0].tolist() for row in near]
    return _traced(voxels, neighbors, junction.astype(np.int64), centers)


def _traced(voxels: Index, neighbors: list[list[int]], junction: Index, centers: Array) -> list[Chain]:
    """Follow every line from its ends, then what is left: rings, and junctions without lines are no chains."""
    used: set[int] = set()
    chains = []
    plain = [k for k in range(len(voxels)) if junction[k] < 0]
    inner = {k: [n for n in neighbors[k] if junction[n] < 0] for k in plain}
    starts = [k for k in plain if len(inner[k]) < 2]
    for start in [*starts, *plain]:
        if start in used:
            continue
        way = [start]
        used.add(start)
        while True:
            following = next((n for n in inner[way[-1]] if n not in used), None)
            if following is None:
                break
            way.append(following)
            used.add(following)
        chains.append(_chain(way, voxels, neighbors, junction, centers))
    return chains


def _chain(way: list[int], voxels: Index, neighbors: list[list[int]], junction: Index, centers: Array) -> Chain:
    """A chain with the junctions at its ends."""
    own = voxels[way]
    at = [_junction_at(way[k], neighbors, junction) for k in (0, -1)]
    if len(way) == 1:  # between two junctions, or at one
        touched = sorted({int(junction[n]) for n in neighbors[way[0]] if junction[n] >= 0})
        at = [*touched[:2], *[-1] * (2 - len(touched[:2]))]
    ring = at == [-1, -1] and len(way) > 2 and way[0] in neighbors[way[-1]]
    pieces = [centers[at[0]][None]] if at[0] >= 0 else []
    pieces.append(own.astype(float))
    if at[1] >= 0:
        pieces.append(centers[at[1]][None])
    if ring:
        pieces.append(own[:1].astype(float))
    first, last = (
        k if k >= 0 else len(centers) + end for k, end in zip(at, (way[0], way[0] if ring else way[-1]), strict=True)
    )
    free = (at[0] < 0) != (at[1] < 0)
    return Chain(np.concatenate(pieces), own, (first, last), (0 if at[0] < 0 else 1) if free else -1)


def _junction_at(voxel: int, neighbors: list[list[int]], junction: Index) -> int:
    return next((int(junction[n]) for n in neighbors[voxel] if junction[n] >= 0), -1)
