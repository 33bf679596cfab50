"""Walls: the barriers and the rims of the regions of interest at one scale, which nothing crosses.

Whether a move crosses a wall is decided exactly, by the crossing of two segments; touching counts. Since a particle is
never on a wall, the sides of a wall are told apart by the same sums at every step, and no speed, however great, and no
barrier, however thin, lets anything through. How far away the nearest wall is at least is kept for every pixel, so that
hardly any move needs to be looked at closely.
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
"""Distance of the places along a wall by which the pixels near it are told [px]."""

_FAR = 12
"""Distance from which on nothing is nearer: hardly any move is that long [px]."""

_ROUNDING = 2.0
"""What the distance of two pixels may exceed that of a place in one from a wall in the other by: half a diagonal twice,
and half the sampling [px]."""


class BarrierMap(NamedTuple):
    """The walls of one scale; a plain tuple for the compiled loops.

    Attributes
    ----------
    segments : ndarray, shape (S, 4)
        Row and column of one end, then of the other [px of the scale].
    clearance : ndarray, shape (H, W)
        Distance that anywhere in a pixel no wall is nearer than [px]; may be below 0.
    """

    segments: Array
    clearance: Array

    def crossed(self, start: Array, end: Array) -> NDArray[np.bool_]:
        """Which of the straight ways from `start` to `end`, shapes (N, 2) [px], cross or touch a wall."""
        if not len(self.segments):
            return np.zeros(len(start), np.bool_)
        return _crossed(self, np.ascontiguousarray(start, dtype=float), np.ascontiguousarray(end, dtype=float))


NO_BARRIERS = BarrierMap(np.zeros((0, 4)), np.zeros((1, 1)))


def build_barrier_map(regions: Regions, shape: tuple[int, ...]) -> BarrierMap:
    """Walls of regions.

    Parameters
    ----------
    regions : Regions
        In px of the scale.
    shape : tuple of int
        Shape of the image at this scale.

    Returns
    -------
    BarrierMap
        Barriers and rims of the regions of interest.
    """
    segments = np.concatenate([regions.rims(), regions.lines()])
    if not len(segments):
        return NO_BARRIERS
    clearance = np.full(shape, float(_FAR))
    _clear(segments, clearance)
    clearance -= _ROUNDING
    return BarrierMap(segments, clearance)


@compiled
def _clear(segments: Array, clearance: Array) -> None:
    """Distance of every pixel to the nearest one that a wall runs through, as far as it is not far."""
    rows, cols = clearance.shape
    walled = np.zeros((rows, cols), np.bool_)
    for s in range(len(segments)):
        down, right = segments[s, 2] - segments[s, 0], segments[s, 3] - segments[s, 1]
        count = 1 + int(np.sqrt(down**2 + right**2) / _SAMPLING)
        for n in range(count + 1):
            y, x = np.rint(segments[s, 0] + down * n / count), np.rint(segments[s, 1] + right * n / count)
            if y < -1 or y > rows or x < -1 or x > cols:
                continue
            row, col = min(max(int(y), 0), rows - 1), min(max(int(x), 0), cols - 1)
            if walled[row, col]:
                continue
            walled[row, col] = True
            for r in range(max(row - _FAR, 0), min(row + _FAR + 1, rows)):
                for c in range(max(col - _FAR, 0), min(col + _FAR + 1, cols)):
                    clearance[r, c] = min(clearance[r, c], np.sqrt(float((r - row) ** 2 + (c - col) ** 2)))


@compiled
def crosses(barrier_map: BarrierMap, a: Array, b: Array) -> bool:
    """Whether the straight way from a to b crosses or touches a wall."""
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
