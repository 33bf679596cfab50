"""Basins of a landscape, none of which reaches across a line: from every pixel the water runs down to one of them.

The watershed by steepest descent (Meyer 1994, DOI 10.1016/0165-1684(94)90060-4), and the merging of basins that are
shallow or small, from the lowest pass between two of them to the highest. Written anew since the water must not pass
the links that lines cross, and since a user waits for it: that of scikit-image has walls of whole pixels only, and
takes several times as long.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Single
from cpm_core.objects.faces.crossings import Crossings

Labels = NDArray[np.int32]

_LEVELS = 2048
"""Heights that are told apart when basins are merged."""

_LARGE = 100
"""Pixels of a basin that is never too shallow."""


def basins(height: Array, lines: Crossings, depth: float, area: int) -> Labels:
    """Basins of a landscape.

    Parameters
    ----------
    height : ndarray, shape (H, W)
        Height of every pixel, 0 to 1.
    lines : Crossings
        Links that the water does not pass.
    depth : float
        A basin that is less deep than this, up to the lowest pass to a neighbor, becomes a part of that, unless both
        have `_LARGE` pixels or more.
    area : int
        A basin of fewer pixels becomes a part of a neighbor, too.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Basin of every pixel, numbered from 0 in the order of their first pixels.
    """
    flat = np.clip(height, 0.0, 1.0).astype(np.float32).ravel()
    right, down, cols = lines.right >= 0.0, lines.down >= 0.0, height.shape[1]
    right[:, -1], down[-1] = True, True  # nothing leads out of the image
    ways = (right, np.roll(right, 1, axis=1), down, np.roll(down, 1, axis=0))
    closed = np.sum([way << np.int8(k) for k, way in enumerate(ways)], axis=0, dtype=np.int8).ravel()
    basin = _descent(flat, closed, cols)
    _follow(basin)
    _merge(basin, flat, cols, _passes(flat, closed, cols, basin), depth, area)
    return _numbered(basin).reshape(height.shape)


@compiled
def _descent(height: Single, closed: NDArray[np.int8], cols: int) -> Labels:
    """The next pixel on the way down from each; itself where the way ends, one pixel of each basin.

    `closed` has a bit for each link that is closed: 1 to the right, 2 left, 4 down, 8 up.
    On level ground the way leads to the nearest place from which it continues down.
    """
    count = len(height)
    down = np.full(count, -1, np.int32)
    queue, first, last = np.empty(count, np.int32), 0, 0
    for p in range(count):
        least = height[p]
        for k in range(4):
            if not closed[p] & (1 << k):
                q = p + (1, -1, cols, -cols)[k]
                if height[q] < least:
                    least, down[p] = height[q], q
        if down[p] >= 0:
            queue[last] = p
            last += 1
    start = 0
    while True:
        while first < last:
            p = int(queue[first])
            first += 1
            for k in range(4):
                if not closed[p] & (1 << k):
                    q = p + (1, -1, cols, -cols)[k]
                    if down[q] < 0 and height[q] == height[p]:
                        down[q] = p
                        queue[last] = q
                        last += 1
        while start < count and down[start] >= 0:
            start += 1
        if start == count:
            return down
        down[start] = start
        queue[last] = start
        last += 1


@compiled
def _follow(down: Labels) -> None:
    """Replace the next pixel on each way by the last."""
    for p in range(len(down)):
        end = down[p]
        while down[end] != end:
            end = down[end]
        q = p
        while down[q] != end:
            q, down[q] = down[q], end


def _passes(height: Single, closed: NDArray[np.int8], cols: int, basin: Labels) -> Index:
    """Links between different basins from the lowest to the highest, as twice the first pixel, plus 1 for one down."""
    codes, levels = [], []
    for down, step in enumerate((1, cols)):
        first = np.flatnonzero((closed[:-step] & 4**down == 0) & (basin[:-step] != basin[step:]))
        codes.append(2 * first + down)
        levels.append(np.maximum(height[first], height[first + step]).astype(float) * (_LEVELS - 1))
    order = np.lexsort((np.concatenate(codes), np.concatenate(levels).astype(np.int16)))
    return np.concatenate(codes)[order]


@compiled
def _merge(basin: Labels, height: Single, cols: int, passes: Index, depth: float, area: int) -> None:
    """Merge basins across passes; each is known by its lowest pixel, and `basin` points on from those merged."""
    size = np.zeros(len(basin), np.int32)
    for p in range(len(basin)):
        size[basin[p]] += 1
    for code in passes:
        p = code // 2
        q = p + (cols if code % 2 else 1)
        a, b = _root(basin, basin[p]), _root(basin, basin[q])
        if a == b:
            continue
        if height[a] > height[b]:
            a, b = b, a
        smaller = min(size[a], size[b])
        if smaller < area or (smaller < _LARGE and max(height[p], height[q]) - height[b] < depth):
            basin[b] = a
            size[a] += size[b]


@compiled
def _root(basin: Labels, k: int) -> int:
    """The basin that a basin has become part of."""
    while basin[k] != k:
        basin[k] = basin[basin[k]]
        k = basin[k]
    return k


@compiled
def _numbered(basin: Labels) -> Labels:
    """Basins numbered in the order of their first pixels."""
    number = np.full(len(basin), -1, np.int32)
    out = np.empty(len(basin), np.int32)
    count = 0
    for p in range(len(basin)):
        own = _root(basin, p)
        if number[own] < 0:
            number[own] = count
            count += 1
        out[p] = number[own]
    return out
