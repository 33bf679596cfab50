"""The barrier map: the barriers and the boundaries of the regions of interest at one scale, which nothing crosses.

Whether a move crosses a barrier is decided exactly, by the crossing of two segments; touching counts. A particle is
never on a barrier, so the same formula at every step decides on which side it is: no speed is too high and no barrier
too thin. A lower bound of the distance to the nearest barrier is stored for every pixel, so that the exact test is
needed for few moves only.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.image.regions import Regions
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.segments import meet
from cpm_core.numerics.types import Array

_SAMPLING = 0.5
"""Distance of the points along a barrier that mark its pixels [px]."""

_FAR = 12
"""Largest distance that is measured [px]: few moves are as long."""

_ROUNDING = 2.0
"""Largest error of a distance that is measured between pixels instead of points: half a diagonal twice, and half the
sampling [px]."""


class BarrierMap(NamedTuple):
    """The barriers of one scale; a plain tuple for the compiled loops.

    Attributes
    ----------
    segments : ndarray, shape (S, 4)
        Row and column of one end, then of the other [px of the scale].
    clearance : ndarray, shape (H, W)
        Lower bound of the distance from any point of a pixel to the nearest barrier [px]; may be below 0.
    """

    segments: Array
    clearance: Array

    def crossed(self, start: Array, end: Array) -> NDArray[np.bool_]:
        """Which of the straight moves from `start` to `end`, shapes (N, 2) [px], cross or touch a barrier."""
        if not len(self.segments):
            return np.zeros(len(start), np.bool_)
        return _crossed(self, np.ascontiguousarray(start, dtype=float), np.ascontiguousarray(end, dtype=float))


NO_BARRIERS = BarrierMap(np.zeros((0, 4)), np.zeros((1, 1)))


def build_barrier_map(regions: Regions, shape: tuple[int, ...]) -> BarrierMap:
    """Barriers and boundaries of `regions`, in px of the scale, for an image of this shape."""
    segments = np.concatenate([regions.rims(), regions.lines()])
    if not len(segments):
        return NO_BARRIERS
    clearance = np.full(shape, float(_FAR))
    _clear(segments, clearance)
    clearance -= _ROUNDING
    return BarrierMap(segments, clearance)


@compiled
def _clear(segments: Array, clearance: Array) -> None:
    """Distance of every pixel to the nearest pixel of a barrier, up to `_FAR`."""
    rows, cols = clearance.shape
    marked = np.zeros((rows, cols), np.bool_)
    for s in range(len(segments)):
        down, right = segments[s, 2] - segments[s, 0], segments[s, 3] - segments[s, 1]
        count = 1 + int(np.sqrt(down**2 + right**2) / _SAMPLING)
        for n in range(count + 1):
            y, x = np.rint(segments[s, 0] + down * n / count), np.rint(segments[s, 1] + right * n / count)
            if y < -1 or y > rows or x < -1 or x > cols:
                continue
            row, col = min(max(int(y), 0), rows - 1), min(max(int(x), 0), cols - 1)
            if marked[row, col]:
                continue
            marked[row, col] = True
            for r in range(max(row - _FAR, 0), min(row + _FAR + 1, rows)):
                for c in range(max(col - _FAR, 0), min(col + _FAR + 1, cols)):
                    clearance[r, c] = min(clearance[r, c], np.sqrt(float((r - row) ** 2 + (c - col) ** 2)))


@compiled
def crosses(barrier_map: BarrierMap, a: Array, b: Array) -> bool:
    """Whether the straight line from a to b crosses or touches a barrier."""
    if len(barrier_map.segments) == 0:
        return False
    rows, cols = barrier_map.clearance.shape
    row = min(max(np.int64(a[0] + 0.5), 0), rows - 1)
    col = min(max(np.int64(a[1] + 0.5), 0), cols - 1)
    clear = barrier_map.clearance[row, col]
    if clear > 0.0 and (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2 < clear * clear:
        return False
    s = 0
    while s < len(barrier_map.segments) and not meet(barrier_map.segments[s], a, b):
        s += 1
    return s < len(barrier_map.segments)


@compiled
def _crossed(barrier_map: BarrierMap, start: Array, end: Array) -> NDArray[np.bool_]:
    out = np.zeros(len(start), np.bool_)
    for i in range(len(start)):
        out[i] = crosses(barrier_map, start[i], end[i])
    return out
