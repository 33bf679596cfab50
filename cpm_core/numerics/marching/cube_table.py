"""How the surface passes through a cube of eight voxels, for each of the 256 ways in which they lie inside or outside.

On every side of a cube, voxels inside that meet only at a corner are joined, and two opposite corners of the cube are
joined by a tube: the parts of the surface are then those of the inside with 26 neighbors and of the outside with 6
(Han, Xu and Prince 2003, DOI 10.1109/TPAMI.2003.1201824). Two cubes agree on the side between them, and no triangle
has a diagonal in a side, so that every edge of the surface has exactly two triangles.

Corner number `4 p + 2 r + c` of a cube lies at the offset (p, r, c); edge number `4 axis + k` joins the k-th corner
without that offset to the one with it.
"""

from __future__ import annotations

from functools import cache
from itertools import product

import numpy as np

from cpm_core.numerics.types import Array, Index

_STEPS = (4, 2, 1)
"""What an offset along an axis adds to the number of a corner."""

EDGES = tuple((corner, corner + step) for step in _STEPS for corner in range(8) if not corner & step)
"""Corners of the twelve edges, the lower one first."""

_EDGE_OF = {pair: number for number, ends in enumerate(EDGES) for pair in (ends, ends[::-1])}

_OFFSETS: Array = np.array(list(product((0.0, 1.0), repeat=3)))
_MIDDLES: Array = np.array([(_OFFSETS[a] + _OFFSETS[b]) / 2.0 for a, b in EDGES])

MOST_TRIANGLES = 6
"""Largest number of triangles in a cube."""


def _sides() -> tuple[tuple[int, ...], ...]:
    """Corners of the six sides of a cube, counter-clockwise as seen from outside."""
    sides = []
    for axis, step in enumerate(_STEPS):
        one, other = _STEPS[(axis + 1) % 3], _STEPS[(axis + 2) % 3]
        ring = (0, one, one + other, other)
        sides.append(tuple(step + corner for corner in ring))
        sides.append(ring[::-1])
    return tuple(sides)


_SIDES = _sides()
_SIDES_OF_EDGE = tuple({n for n, side in enumerate(_SIDES) if {a, b} <= set(side)} for a, b in EDGES)


@cache
def triangles_by_case() -> tuple[Index, Index]:
    """Triangles of each case as edges of the cube, (256, MOST_TRIANGLES, 3), and their number, (256,).

    Bit k of a case tells whether corner k lies inside. Seen from outside, triangles run counter-clockwise.
    """
    table, counts = np.zeros((256, MOST_TRIANGLES, 3), np.int64), np.zeros(256, np.int64)
    for case in range(256):
        inside = [bool(case >> corner & 1) for corner in range(8)]
        loops = _loops(inside)
        opposite = len(loops) == 2 and sum(inside) == 2
        triangles = _tube(*loops) if opposite else [t for loop in loops for t in _triangulated(loop)]
        counts[case] = len(triangles)
        table[case, : len(triangles)] = np.array(triangles, np.int64).reshape(-1, 3)
    return table, counts


def _loops(inside: list[bool]) -> list[list[int]]:
    """Closed ways of the surface over the sides of a cube, each as the edges that it crosses."""
    following = {}
    for side in _SIDES:
        crossed = [(side[k - 1], side[k]) for k in range(4) if inside[side[k - 1]] != inside[side[k]]]
        for k, (a, b) in enumerate(crossed):
            if inside[a]:  # around the corners outside, to where the inside begins again
                following[_EDGE_OF[a, b]] = _EDGE_OF[crossed[(k + 1) % len(crossed)]]
    loops = []
    while following:
        loop = [next(iter(following))]
        while following[loop[-1]] != loop[0]:
            loop.append(following[loop[-1]])
        loops.append(loop[::-1])
        for edge in loop:
            del following[edge]
    return loops


def _triangulated(loop: list[int]) -> list[tuple[int, int, int]]:
    """Triangles that fill a loop, with the shortest diagonals of which none lies in a side of the cube."""

    @cache
    def best(first: int, last: int) -> tuple[float, tuple[tuple[int, int, int], ...]]:
        if last - first < 2:
            return 0.0, ()
        choices = []
        for between in range(first + 1, last):
            left, right = best(first, between), best(between, last)
            own = (loop[first], loop[between], loop[last])
            choices.append((left[0] + right[0] + price(first, last), (*left[1], own, *right[1])))
        return min(choices)

    def price(first: int, last: int) -> float:
        a, b = loop[first], loop[last]
        if last - first in (1, len(loop) - 1):
            return 0.0
        return float(np.inf if _SIDES_OF_EDGE[a] & _SIDES_OF_EDGE[b] else ((_MIDDLES[a] - _MIDDLES[b]) ** 2).sum())

    total, triangles = best(0, len(loop) - 1)
    assert total < np.inf
    return list(triangles)


def _tube(one: list[int], other: list[int]) -> list[tuple[int, int, int]]:
    """Six triangles that join two loops around opposite corners, each edge to the two nearest of the other loop."""
    axes = {edge // 4: edge for edge in other}
    triangles = []
    for k in range(3):
        a, b, c = one[k - 2], one[k - 1], one[k]
        triangles.append((a, b, axes[c // 4]))
        triangles.append((axes[a // 4], axes[c // 4], b))
    return triangles
