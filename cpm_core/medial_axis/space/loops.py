"""Loops of what a boundary in a volume encloses, and which of them are linked."""

from __future__ import annotations

import numpy as np
import scipy

from cpm_core.medial_axis.space.thinning import thinned
from cpm_core.medial_axis.space.voxel_graph import Chain, chains_of
from cpm_core.numerics.runs import runs_of
from cpm_core.numerics.types import Array, Index, Mask

_OFF_GRID = np.array([0.0317, 0.0271, 0.0193])
"""Offset of one loop from another [voxels], so that no segment meets the edge of a triangle."""

_AT_ONCE = 1_000_000
"""Pairs of a segment and a triangle that are tested at once."""


def loops_of(boundary: Index) -> list[Array]:
    """Loops along the center lines of what a boundary encloses, each of shape (K, 3), closed.

    `boundary`, shape (M, 3), are voxels on it. Every other closed way in there is made up of these loops.
    """
    low = boundary.min(0) - 3
    solid = np.zeros(boundary.max(0) - low + 4, np.bool_)
    solid[tuple((boundary - low).T)] = True
    solid = _filled(np.asarray(scipy.ndimage.binary_dilation(solid, np.ones((3, 3, 3), bool))))
    lines = thinned(solid, scipy.ndimage.distance_transform_edt(solid))
    return [loop + low for loop in _cycles(chains_of(lines))]


def _filled(mask: Mask) -> Mask:
    """A mask with its hollows."""
    empty = runs_of(~mask, corners=False)
    hollow = np.flatnonzero(~empty.at_border)
    if not len(hollow):
        return mask
    voxels = np.argwhere(~mask)
    filled = mask.copy()
    filled[tuple(voxels[np.isin(empty.part_at(voxels), hollow)].T)] = True
    return filled


def _cycles(chains: list[Chain]) -> list[Array]:
    """A loop for each chain beyond those of a spanning tree: the chain, and the way back through the tree."""
    way: dict[int, tuple[int, Array]] = {}  # node -> the one before it, and the points from there
    places: dict[int, list[tuple[int, int, Array]]] = {}
    for k, chain in enumerate(chains):
        places.setdefault(chain.nodes[0], []).append((k, chain.nodes[1], chain.points))
        places.setdefault(chain.nodes[1], []).append((k, chain.nodes[0], chain.points[::-1]))
    seen: set[int] = set()
    used: set[int] = set()
    loops = []
    for root in places:
        if root in seen:
            continue
        seen.add(root)
        waiting = [root]
        while waiting:
            node = waiting.pop(0)
            for k, other, points in places[node]:
                if k in used:
                    continue
                used.add(k)
                if other in seen:
                    back = _way_up(way, node), _way_up(way, other)
                    loops.append(np.concatenate([back[0][::-1], points, back[1]]))
                else:
                    seen.add(other)
                    way[other] = node, points
                    waiting.append(other)
    return loops


def _way_up(way: dict[int, tuple[int, Array]], node: int) -> Array:
    """The points from a node to the root of its tree."""
    pieces = [np.empty((0, 3))]
    while node in way:
        node, points = way[node]
        pieces.append(points[::-1])
    return np.concatenate(pieces)


def are_linked(one: Array, other: Array) -> bool:
    """Whether the linking number of two closed loops, shape (K, 3), is other than zero.

    It is the number of times that one passes through a surface with the other as its rim, counted by direction; the
    surface is made of triangles around the middle of the rim.
    """
    tip = other.mean(0)
    a, b = other - tip, np.roll(other, -1, axis=0) - tip
    start = one - tip + _OFF_GRID
    end = np.roll(start, -1, axis=0)
    step = max(1, _AT_ONCE // len(a))
    return sum(_crossings(start[k : k + step], end[k : k + step], a, b) for k in range(0, len(start), step)) != 0


def _crossings(start: Array, end: Array, a: Array, b: Array) -> int:
    """Number of segments that pass through triangles with a corner at the origin, in one direction less the other."""
    normal = np.cross(a, b)
    from_, to = start @ normal.T, end @ normal.T
    segment, triangle = np.nonzero((from_ < 0.0) != (to < 0.0))
    if not len(segment):
        return 0
    p, n = start[segment], normal[triangle]
    before, after = from_[segment, triangle], to[segment, triangle]
    place = p + (before / (before - after))[:, None] * (end[segment] - p)
    inside = np.ones(len(segment), bool)
    for u, v in ((np.zeros_like(n), a[triangle]), (a[triangle], b[triangle]), (b[triangle], np.zeros_like(n))):
        inside &= np.einsum("ij,ij->i", np.cross(v - u, place - u), n) >= 0.0
    return int(np.where(before < 0.0, 1, -1)[inside].sum())
