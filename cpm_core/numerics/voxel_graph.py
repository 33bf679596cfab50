"""Voxels as graphs: solids thinned to lines, chains between ends and branches, and closed loops in solids."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np
import scipy

from cpm_core.numerics.grids import label_parts
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask


def thin_to_lines(inside: Mask, depth: Array) -> Mask:
    """Thin a mask whose outermost voxels are False to lines of voxels in its middle.

    `inside` and `depth`, the distance inward, have the shape (P, R, C), as the result.
    """
    lines = inside.copy()
    voxels = np.argwhere(lines)
    voxels = voxels[np.argsort(depth[tuple(voxels.T)], kind="stable")]
    while _remove_simple_voxels(lines, voxels):
        voxels = voxels[lines[tuple(voxels.T)]]
    return lines


def _cube_bits(chosen: Callable[[int, int, int], bool]) -> int:
    """Return the selected ones of the 27 voxels of a cube as bits, by their places along the axes from -1 to 1."""
    return sum(1 << k for k, step in enumerate(product((-1, 0, 1), repeat=3)) if chosen(*step))


_FACE_NEIGHBORS = _cube_bits(lambda p, r, c: abs(p) + abs(r) + abs(c) == 1)
"""Voxels of the cube that share a face with the middle one."""

_EDGE_NEIGHBORS = _cube_bits(lambda p, r, c: 1 <= abs(p) + abs(r) + abs(c) <= 2)
"""Voxels of the cube that share a face or an edge with the middle one."""

_HAS_UPPER = _cube_bits(lambda p, r, c: r > -1)
"""Voxels of the cube with another one in the row before."""

_HAS_LOWER = _cube_bits(lambda p, r, c: r < 1)
"""Voxels of the cube with another one in the row behind."""

_HAS_LEFT = _cube_bits(lambda p, r, c: c > -1)
"""Voxels of the cube with another one in the column before."""

_HAS_RIGHT = _cube_bits(lambda p, r, c: c < 1)
"""Voxels of the cube with another one in the column behind."""


@compiled
def _remove_simple_voxels(lines: Mask, voxels: Index) -> int:
    """Remove simple voxels, in order; return their number.

    Around a simple voxel the inside is connected, and so is the outside across faces.
    """
    taken = 0
    for n in range(len(voxels)):
        p, r, c = voxels[n]
        if (
            lines[p - 1, r, c] and lines[p + 1, r, c] and lines[p, r - 1, c]
            and lines[p, r + 1, c] and lines[p, r, c - 1] and lines[p, r, c + 1]
        ):  # fmt: skip
            continue  # the outside does not touch it, as most of them
        around = 0
        for k in range(27):
            around |= int(lines[p + k // 9 - 1, r + k // 3 % 3 - 1, c + k % 3 - 1]) << k
        around &= ~(1 << 13)
        outside = ~around & _EDGE_NEIGHBORS
        if (
            around & (around - 1)
            and _are_connected(around, around, True)
            and _are_connected(outside, outside & _FACE_NEIGHBORS, False)
        ):
            lines[p, r, c] = False
            taken += 1
    return taken


@compiled
def _are_connected(voxels: int, wanted: int, corners: bool) -> bool:
    """Return whether the `wanted` voxels of a cube, as bits, are connected, over corners or over faces alone."""
    part, before = wanted & -wanted, 0
    while part != before:
        before = part
        grown = part | (part & _HAS_RIGHT) << 1 | (part & _HAS_LEFT) >> 1
        across = grown if corners else part
        grown |= (across & _HAS_LOWER) << 3 | (across & _HAS_UPPER) >> 3
        across = grown if corners else part
        part = (grown | across << 9 | across >> 9) & voxels
    return wanted & ~part == 0


_NEIGHBOR_STEPS = np.array([step for step in product((-1, 0, 1), repeat=3) if any(step)])
"""Steps from a voxel to its 26 neighbors."""


class Chain(NamedTuple):
    """Line of voxels.

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
    def is_spur(self) -> bool:
        """Whether it hangs at a junction with its other end in the open."""
        return self.free_end >= 0


def find_chains(lines: Mask) -> list[Chain]:
    """Find the chains of a mask of lines one voxel thick, whose outermost voxels are False."""
    voxels = np.argwhere(lines)
    number = np.full(lines.shape, -1, np.int64)
    number[tuple(voxels.T)] = np.arange(len(voxels))
    near = number[tuple((voxels[:, None] + _NEIGHBOR_STEPS).transpose(2, 0, 1))]
    degree = (near >= 0).sum(1)
    crowded = np.zeros(lines.shape, bool)
    crowded[tuple(voxels[degree > 2].T)] = True
    labels, count = label_parts(crowded)
    junction = labels[tuple(voxels.T)] - 1  # -1 for voxels of chains
    centers = np.array([voxels[junction == k].mean(0) for k in range(count)]).reshape(-1, 3)
    neighbors = [row[row >= 0].tolist() for row in near]
    # follow every line from its ends, then the remaining rings; junctions without lines are no chains
    used, chains = set[int](), list[Chain]()
    plain = [k for k in range(len(voxels)) if junction[k] < 0]
    inner = {k: [n for n in neighbors[k] if junction[n] < 0] for k in plain}
    for start in (*(k for k in plain if len(inner[k]) < 2), *plain):
        if start in used:
            continue
        way, following = list[int](), start
        while following >= 0:
            way.append(following)
            used.add(following)
            following = next((n for n in inner[following] if n not in used), -1)
        own = voxels[way]
        at = [next((int(junction[n]) for n in neighbors[end] if junction[n] >= 0), -1) for end in (way[0], way[-1])]
        if len(way) == 1:  # between two junctions, or at one
            touched = sorted({int(junction[n]) for n in neighbors[way[0]] if junction[n] >= 0})
            at = [*touched[:2], *[-1] * (2 - len(touched[:2]))]
        ring = at == [-1, -1] and len(way) > 2 and way[0] in neighbors[way[-1]]
        before, behind = (centers[[k]] if k >= 0 else centers[:0] for k in at)
        ends = zip(at, (way[0], way[0] if ring else way[-1]), strict=True)
        first, last = (k if k >= 0 else len(centers) + end for k, end in ends)
        free_end = (0 if at[0] < 0 else 1) if (at[0] < 0) != (at[1] < 0) else -1
        chains.append(Chain(np.concatenate([before, own, behind, own[:ring]]), own, (first, last), free_end))
    return chains


_LOOP_OFFSET = np.array([0.0317, 0.0271, 0.0193])
"""Offset of one loop from another [voxels], so that no segment meets the edge of a triangle."""

_PAIRS_PER_PASS = 1_000_000
"""Number of pairs of a segment and a triangle that are tested together."""


def find_loops(boundary: Index) -> list[Array]:
    """Find loops along the center lines of the solid that a boundary encloses, each of shape (K, 3), closed.

    `boundary`, shape (M, 3), are voxels on it. Every other closed path in there is a combination of these loops.
    """
    low = boundary.min(0) - 3
    solid = np.zeros(boundary.max(0) - low + 4, bool)
    solid[tuple((boundary - low).T)] = True
    solid = scipy.ndimage.binary_fill_holes(scipy.ndimage.binary_dilation(solid, np.ones((3, 3, 3), bool)))
    lines = thin_to_lines(solid, scipy.ndimage.distance_transform_cdt(solid).astype(float))
    # a chain between two nodes that other chains connect already closes a loop
    ways: dict[int, list[tuple[int, Array]]] = defaultdict(list)
    loops = []
    for chain in find_chains(lines):
        first, last = chain.nodes
        back = _find_forest_path(ways, last, first)
        if back is None:
            ways[first].append((last, chain.points))
            ways[last].append((first, chain.points[::-1]))
        else:
            loops.append(np.concatenate([chain.points, *back]) + low)
    return loops


def _find_forest_path(ways: dict[int, list[tuple[int, Array]]], start: int, end: int) -> list[Array] | None:
    """Return the points of the chains along the one path through a forest; None where there is none."""
    waiting: list[tuple[int, int, list[Array]]] = [(start, -1, [])]
    while waiting:
        node, before, pieces = waiting.pop()
        if node == end:
            return pieces
        waiting += [(other, node, [*pieces, points]) for other, points in ways[node] if other != before]
    return None


def linking_number(one: Array, other: Array) -> int:
    """Count how often a loop winds around another, both of shape (K, 3) and closed.

    It passes as often through a surface with the other as its rim, counted by direction: triangles around its middle.
    """
    tip = other.mean(0)
    a, b = other - tip, np.roll(other, -1, axis=0) - tip
    loop, normal = one - tip + _LOOP_OFFSET, np.cross(a, b)
    following, step, total = np.roll(loop, -1, axis=0), max(1, _PAIRS_PER_PASS // len(a)), 0
    for k in range(0, len(loop), step):
        start, end = loop[k : k + step], following[k : k + step]
        from_, to = start @ normal.T, end @ normal.T
        segment, triangle = np.nonzero((from_ < 0.0) != (to < 0.0))
        before, after = from_[segment, triangle], to[segment, triangle]
        place = start[segment] + (before / (before - after))[:, None] * (end[segment] - start[segment])
        n = normal[triangle]
        inside = np.ones(len(segment), bool)
        for u, v in ((np.zeros_like(n), a[triangle]), (a[triangle], b[triangle]), (b[triangle], np.zeros_like(n))):
            inside &= np.einsum("ij,ij->i", np.cross(v - u, place - u), n) >= 0.0
        total += int((np.where(before < 0.0, 1, -1) * inside).sum())
    return total
