"""Loops of what a boundary in a volume encloses, and what they are linked with.

A closed way is linked with a loop if it passes through a surface with the loop as its rim a number of times, counted by
direction, that is not zero. Of a graph of places only the edges that pass through the surface matter: there is such a
way unless each place can be given a height that changes along every edge as often as the edge passes.
"""

from __future__ import annotations

from itertools import product

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

_AHEAD = np.array([step for step in product((-1, 0, 1), repeat=3) if step > (0, 0, 0)])
"""Half of the steps to the 26 voxels around one."""


def loops_of(boundary: Index) -> list[Array]:
    """Loops along the center lines of what a boundary encloses, each of shape (K, 3), closed.

    `boundary`, shape (M, 3), are voxels on it. Every other closed way in there is made up of these loops.
    """
    low = boundary.min(0) - 3
    solid = np.zeros(boundary.max(0) - low + 4, np.bool_)
    solid[tuple((boundary - low).T)] = True
    solid = _filled(np.asarray(scipy.ndimage.binary_dilation(solid, np.ones((3, 3, 3), bool))))
    lines = thinned(solid, scipy.ndimage.distance_transform_cdt(solid).astype(float))
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


def neighbors(voxels: Index) -> Index:
    """Pairs of voxels, shape (N, 3), that touch each other by a side, an edge or a corner: their indices, (E, 2)."""
    if not len(voxels):
        return np.empty((0, 2), np.int64)
    place = voxels - voxels.min(0) + 1
    sides = place.max(0) + 2
    number = np.ravel_multi_index(tuple(place.T), tuple(sides))
    order = np.argsort(number, kind="stable")
    number = number[order]
    pairs = []
    for step in _AHEAD:
        wanted = number + (step[0] * sides[1] + step[1]) * sides[2] + step[2]
        at = np.minimum(np.searchsorted(number, wanted), len(number) - 1)
        met = number[at] == wanted
        pairs.append(np.stack([order[met], order[at[met]]], axis=1))
    return np.concatenate(pairs)


def passes(start: Array, end: Array, loop: Array) -> Index:
    """How often segments, shape (N, 3) each, pass through a surface with a loop as its rim, counted by direction.

    The surface is made of triangles around the middle of the loop, which has the shape (K, 3) and is closed.
    """
    tip = loop.mean(0)
    a, b = loop - tip, np.roll(loop, -1, axis=0) - tip
    step = max(1, _AT_ONCE // len(a))
    from_, to = start - tip + _OFF_GRID, end - tip + _OFF_GRID
    found = [_passes(from_[k : k + step], to[k : k + step], a, b) for k in range(0, len(start), step)]
    return np.concatenate([np.zeros(0, np.int64), *found])


def _passes(start: Array, end: Array, a: Array, b: Array) -> Index:
    """How often segments pass through triangles with one corner at the origin and the others at `a` and `b`."""
    normal = np.cross(a, b)
    from_, to = start @ normal.T, end @ normal.T
    segment, triangle = np.nonzero((from_ < 0.0) != (to < 0.0))
    before, after = from_[segment, triangle], to[segment, triangle]
    place = start[segment] + (before / (before - after))[:, None] * (end[segment] - start[segment])
    n = normal[triangle]
    inside = np.ones(len(segment), bool)
    for u, v in ((np.zeros_like(n), a[triangle]), (a[triangle], b[triangle]), (b[triangle], np.zeros_like(n))):
        inside &= np.einsum("ij,ij->i", np.cross(v - u, place - u), n) >= 0.0
    turns = np.where(before < 0.0, 1, -1) * inside
    return np.bincount(segment, turns, minlength=len(start)).astype(np.int64)


def winds(count: int, pairs: Index, turns: Index) -> bool:
    """Whether a closed way through a graph makes turns: those of its edges, shape (E,), do not add up to zero.

    `pairs`, shape (E, 2), are the edges between `count` places; against their direction they turn the other way.
    """
    plain = pairs[turns == 0]
    graph = scipy.sparse.coo_array((np.ones(len(plain), np.int8), (plain[:, 0], plain[:, 1])), shape=(count, count))
    _, part = scipy.sparse.csgraph.connected_components(graph, directed=False)
    turning = turns != 0
    edges = np.unique(np.column_stack([part[pairs[turning]], turns[turning]]), axis=0).tolist()
    ways: dict[int, list[tuple[int, int]]] = {}
    for one, other, turn in edges:
        ways.setdefault(one, []).append((other, turn))
        ways.setdefault(other, []).append((one, -turn))
    height: dict[int, int] = {}
    for root in ways:
        waiting = [] if root in height else [root]
        height.setdefault(root, 0)
        while waiting:
            node = waiting.pop()
            for other, turn in ways[node]:
                if other not in height:
                    height[other] = height[node] + turn
                    waiting.append(other)
                elif height[other] != height[node] + turn:
                    return True
    return False
