"""Floods: the pixels around some places, in the order in which a rising level reaches them.

The pixels that a level has reached are a connected component of a threshold image, as those of which maximally stable
extremal regions are chosen (Matas et al. 2002, DOI 10.5244/C.16.36).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Index, Mask
from cpm_core.objects.candidates.grids import Box

_LEAST = 12
"""Pixels of the smallest region."""

_RISE = 12
"""Levels over which the growth of a region is measured."""

_JUMP = 1.15
"""Growth in the next level before which a region is always one to look at."""


class Flood(NamedTuple):
    """A flood.

    Attributes
    ----------
    position : ndarray of int32, shape (H, W)
        Number of pixels that were reached before each; larger than any count where the flood did not come.
    counts : ndarray of int64, shape (L,)
        Pixels reached at the end of each level.
    boxes : ndarray of int64, shape (L, 4)
        The boxes of these pixels.
    levels : ndarray of int64, shape (L,)
        These levels.
    """

    position: NDArray[np.int32]
    counts: Index
    boxes: Index
    levels: Index

    def regions(self, growth: float, most: int) -> list[tuple[int, Box, float]]:
        """Counts, boxes and instability of at most `most` levels.

        Each is larger than the one before by the factor `growth`, or stands before a jump. The instability is the
        logarithm of the factor by which the region grows while the level rises by `_RISE`.
        """
        following = np.append(self.counts[1:], np.iinfo(np.int64).max)[: len(self.counts)]
        found, last = [], 0.0
        for k, (count, after) in enumerate(zip(self.counts.tolist(), following.tolist(), strict=True)):
            if count >= _LEAST and (count >= last * growth or after > count * _JUMP):
                found.append(k)
                last = count
        if len(found) > most:
            found = [found[k] for k in np.linspace(0, len(found) - 1, most).round().astype(int).tolist()]
        boxes = self.boxes.tolist()
        later = np.searchsorted(self.levels, self.levels[found] + _RISE, side="right") - 1
        ratios = np.log(self.counts[later] / self.counts[found]).tolist()
        return [
            (int(self.counts[k]), (boxes[k][0], boxes[k][1], boxes[k][2], boxes[k][3]), ratio)
            for k, ratio in zip(found, ratios, strict=True)
        ]


def flood(level: NDArray[np.int16], count: int, allowed: Mask, seeds: Index, most: int) -> Flood:
    """Flood from seeds.

    Parameters
    ----------
    level : ndarray of int16, shape (H, W)
        Level at which each pixel is reached from a neighbor, from 0 to `count` - 1.
    count : int
        Number of levels.
    allowed : ndarray of bool, shape (H, W)
        Pixels that may be reached.
    seeds : ndarray, shape (N, 2)
        Pixels that the flood starts from, at the level that four fifths of them have.
    most : int
        Pixels after which it ends; a level that is not complete by then is left out.
    """
    levels = np.sort(level[seeds[:, 0], seeds[:, 1]])
    start = int(levels[min(int(0.8 * len(levels)), len(levels) - 1)])
    return Flood(*_flood(level, count, allowed, seeds, start, most))


@compiled
def _flood(
    level: NDArray[np.int16], levels: int, allowed: Mask, seeds: Index, current: int, most: int
) -> tuple[NDArray[np.int32], Index, Index, Index]:
    rows, cols = level.shape
    never = np.int32(2**31 - 1)
    position = np.full((rows, cols), never, np.int32)
    head, after = np.full(levels, -1, np.int32), np.full(rows * cols, -1, np.int32)
    seen = np.zeros((rows, cols), np.bool_)
    counts, boxes, reached = np.empty(levels, np.int64), np.empty((levels, 4), np.int64), np.empty(levels, np.int64)
    for k in range(len(seeds)):
        r, c = seeds[k, 0], seeds[k, 1]
        if allowed[r, c] and not seen[r, c]:
            seen[r, c] = True
            at = max(level[r, c], current)
            after[r * cols + c] = head[at]
            head[at] = r * cols + c
    count, made = 0, 0
    top, bottom, left, right = rows, 0, cols, 0
    while count < most:
        if head[current] < 0:
            if count > 0 and (made == 0 or counts[made - 1] < count):
                counts[made], reached[made] = count, current
                boxes[made, 0], boxes[made, 1], boxes[made, 2], boxes[made, 3] = top, bottom, left, right
                made += 1
            while current < levels and head[current] < 0:
                current += 1
            if current == levels:
                break
        pixel = head[current]
        head[current] = after[pixel]
        r, c = pixel // cols, pixel % cols
        position[r, c] = count
        count += 1
        top, bottom, left, right = min(top, r), max(bottom, r + 1), min(left, c), max(right, c + 1)
        for k in range(4):
            y, x = r + (k == 0) - (k == 1), c + (k == 2) - (k == 3)
            if 0 <= y < rows and 0 <= x < cols and allowed[y, x] and not seen[y, x]:
                seen[y, x] = True
                at = max(level[y, x], current)
                after[y * cols + x] = head[at]
                head[at] = y * cols + x
    return position, counts[:made], boxes[:made], reached[:made]
