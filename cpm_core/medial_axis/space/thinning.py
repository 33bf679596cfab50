"""Thinning of a volume to lines of voxels: from the surface inward, without changing the topology.

Voxels are taken away in the order of their distance from the surface (Pudney 1998, DOI 10.1006/cviu.1998.0680) if they
are simple, that is if neither the inside with 26 neighbors nor the outside with 6 is parted or joined by it (Bertrand
and Malandain 1994, DOI 10.1016/0167-8655(94)90046-9), and if they do not end a line.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask


def thinned(inside: Mask, depth: Array) -> Mask:
    """Lines of voxels in the middle of a mask whose outermost voxels are False; `depth` is the distance inward."""
    lines = inside.copy()
    voxels = np.argwhere(lines)
    voxels = voxels[np.argsort(depth[tuple(voxels.T)], kind="stable")]
    while _thin(lines, voxels):
        voxels = voxels[lines[tuple(voxels.T)]]
    return lines


@compiled
def _thin(lines: Mask, voxels: Index) -> int:
    """Take simple voxels away, in order; return their number."""
    around, waiting = np.empty(27, np.bool_), np.empty(27, np.int64)
    taken = 0
    for n in range(len(voxels)):
        p, r, c = voxels[n]
        count = 0
        for k in range(27):
            around[k] = lines[p + k // 9 - 1, r + k // 3 % 3 - 1, c + k % 3 - 1]
            count += around[k]
        if count > 2 and _is_simple(around, waiting):
            lines[p, r, c] = False
            taken += 1
    return taken


@compiled
def _is_simple(around: Mask, waiting: NDArray[np.int64]) -> bool:
    """Whether the inside around the middle of 27 voxels hangs together, and so does the outside at its sides."""
    return _parts(around, waiting, True) == 1 and _parts(around, waiting, False) == 1


@compiled
def _parts(around: Mask, waiting: NDArray[np.int64], inside: bool) -> int:
    """Number of parts of the inside with 26 neighbors, or of the outside with 6 that touch the middle by a side."""
    seen = np.zeros(27, np.bool_)
    count = 0
    for start in range(27):
        x, y, z = start // 9 - 1, start // 3 % 3 - 1, start % 3 - 1
        off = abs(x) + abs(y) + abs(z)
        if start == 13 or seen[start] or around[start] != inside or (not inside and off != 1):
            continue
        count += 1
        seen[start] = True
        waiting[0], many = start, 1
        while many:
            many -= 1
            at = waiting[many]
            for other in range(27):
                if other == 13 or seen[other] or around[other] != inside:
                    continue
                u, v, w = other // 9 - 1, other // 3 % 3 - 1, other % 3 - 1
                if not inside and abs(u) + abs(v) + abs(w) == 3:
                    continue  # corners do not belong to the outside around the middle
                a, b, d = abs(u - (at // 9 - 1)), abs(v - (at // 3 % 3 - 1)), abs(w - (at % 3 - 1))
                if max(a, b, d) == 1 and (inside or a + b + d == 1):
                    seen[other] = True
                    waiting[many] = other
                    many += 1
    return count
