"""Joints: parts of the inside that hang together by a neck thinner than the voxels, joined along the neck.

Where a vessel is about as thin as a voxel, the smoothed volume may sink below the local threshold although the vessel
goes on. Between two parts the way along which the volume stays highest passes a saddle; if it lies in a neck (`necks`),
the voxels of the way are raised. The ways make no loop, since each joins two parts that were apart.
"""

from __future__ import annotations

import numpy as np
import skimage
from numpy.typing import NDArray

from cpm_core.numerics.grids import Parts, parts_of
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Index, Mask, Single
from cpm_core.reconstruction.surface.iso.necks import DEEPEST, Surroundings

Labels = NDArray[np.int32]
"""Parts of voxels."""

_APART = 3
"""Distance between saddles of the same two parts that are looked at [voxels]."""

_WINDOW = 6
"""Voxels around a saddle in which the way is sought."""

RAISED = 0.25
"""Height of the voxels on a way: just inside."""

_MOST_MEETINGS = 4
"""Parts that may meet another one in a voxel."""


def join(height: Single, begin: Index, surroundings: Surroundings) -> int:
    """Raise the voxels of necks in a height just above zero, and return the number of joints.

    `begin` is the first voxel of the height in the volume.
    """
    parts = parts_of(height > 0.0, corners=True)
    if parts.count < 2:
        return 0
    meetings = meetings_of(height, (height <= 0.0) & (height > -DEEPEST), parts, np.ones(parts.count, np.bool_))
    group = np.arange(parts.count)
    looked_at: dict[tuple[int, int], list[Index]] = {}
    joined = 0
    for p, r, c, one, other in meetings:
        a, b = root(group, one), root(group, other)
        saddle, pair = np.array([p, r, c]), (min(one, other), max(one, other))
        tried = looked_at.setdefault(pair, [])
        if a == b or any((np.abs(saddle - before) < _APART).all() for before in tried):
            continue
        tried.append(saddle)
        depth = -float(height[p, r, c])
        way = way_between(height, parts, saddle, one, other, _WINDOW)
        if way is None or not surroundings.is_neck(way + begin, saddle + begin, depth):
            continue
        group[max(a, b)] = min(a, b)
        joined += 1
        inner = tuple(way.T)
        height[inner] = np.maximum(height[inner], RAISED)
    return joined


def meetings_of(values: Single, passable: Mask, parts: Parts, wanted: Mask) -> Index:
    """Voxels, and the two parts, where the slopes of different wanted parts meet, the highest first, shape (M, 5)."""
    own: Labels = np.where(np.concatenate([[False], wanted]), np.arange(parts.count + 1), 0).astype(np.int32)[
        parts.labels
    ]
    low = np.argwhere(passable & (own == 0))
    low = low[np.argsort(-values[tuple(low.T)], kind="stable")]
    basin = np.arange(parts.count + len(low) + 1)
    found = np.empty((_MOST_MEETINGS * len(low), 5), np.int64)
    return found[: _descend(values, own, low, parts.count, basin, found)]


@compiled
def root(group: Index, k: int) -> int:
    """First member of the group that a number belongs to; the way to it is shortened."""
    while group[k] != k:
        group[k] = group[group[k]]
        k = group[k]
    return k


@compiled
def _descend(height: Single, own: Labels, low: Index, count: int, basin: Index, found: Index) -> int:
    """Give voxels, from high to low, to the part whose slope they lie on; note where two parts meet.

    A voxel without a higher neighbor begins a basin of its own, which goes to the first part that reaches it.
    """
    planes, rows, cols = height.shape
    seen = np.empty(27, np.int64)
    met = 0
    for n in range(len(low)):
        p, r, c = low[n]
        many, mine = 0, -1
        highest = -np.inf
        for u in range(max(p - 1, 0), min(p + 2, planes)):
            for v in range(max(r - 1, 0), min(r + 2, rows)):
                for w in range(max(c - 1, 0), min(c + 2, cols)):
                    if own[u, v, w] > 0:
                        lead = root(basin, own[u, v, w])
                        if lead <= count and height[u, v, w] > highest:
                            highest, mine = height[u, v, w], lead
                        new = True
                        for k in range(many):
                            new = new and seen[k] != lead
                        if new:
                            seen[many] = lead
                            many += 1
        if mine < 0:
            mine = seen[0] if many else count + 1 + n
        own[p, r, c] = mine
        noted = 0
        for k in range(many):
            if seen[k] > count:
                basin[seen[k]] = mine
            elif seen[k] != mine and noted < _MOST_MEETINGS:
                found[met, 0], found[met, 1], found[met, 2] = p, r, c
                found[met, 3], found[met, 4] = mine - 1, seen[k] - 1
                noted += 1
                met += 1
    return met


def way_between(values: Single, parts: Parts, saddle: Index, one: int, other: int, reach: int) -> Index | None:
    """Shortest way between two parts over voxels no lower than a saddle, through it, ends included; None without.

    Voxels up to `reach` from the saddle are looked at.
    """
    low = np.maximum(saddle - reach, 0)
    passable = values[tuple(slice(a, b) for a, b in zip(low, saddle + reach + 1, strict=True))] >= values[tuple(saddle)]
    costs = skimage.graph.MCP_Geometric(np.where(passable, 1.0, -1.0))
    reached, _ = costs.find_costs([tuple(saddle - low)])
    voxels = np.argwhere(passable)
    part = parts.part_at(voxels + low)
    halves = []
    for wanted in (one, other):
        ends = voxels[part == wanted]
        cost = reached[tuple(ends.T)]
        if not len(ends) or not np.isfinite(cost).any():
            return None
        halves.append(np.array(costs.traceback(tuple(ends[cost.argmin()]))) + low)
    return np.concatenate([halves[0][::-1], halves[1][1:]])
