"""Grids on which candidates are looked at: all pixels of a small box, and every second, fourth ... of a larger one."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Index, Mask

Box = tuple[int, int, int, int]
"""First row, row behind the last, first column, column behind the last."""

_BUDGET = 48 * 48
"""Points that a grid has at most, without its margin."""

_MARGIN = 6
_COARSEST = 4


class Grid(NamedTuple):
    """A grid of pixels.

    Attributes
    ----------
    scale : int
        It has every ``2 ** scale``-th pixel of each axis.
    top, left : int
        Place of its first point among all points of this scale.
    rows, cols : ndarray of int64
        Rows and columns of its pixels.
    at_border : tuple of bool
        Whether it ends at the upper, left, lower, right border of the image.
    """

    scale: int
    top: int
    left: int
    rows: Index
    cols: Index
    at_border: tuple[bool, bool, bool, bool]

    def of(self, mask: Mask) -> Mask:
        """What a mask of the whole image, shape (H, W), is at the points."""
        if self.scale == 0:
            return np.ascontiguousarray(mask[self.rows[0] : self.rows[-1] + 1, self.cols[0] : self.cols[-1] + 1])
        return np.asarray(mask[self.rows[:, None], self.cols])

    def nearest(self, pixels: Index) -> Index:
        """Points nearest to pixels of the image, both of shape (N, 2)."""
        limit = np.array([len(self.rows) - 1, len(self.cols) - 1])
        return np.asarray(np.clip((pixels >> self.scale) - (self.top, self.left), 0, limit))


def grid_over(box: Box, shape: tuple[int, ...]) -> Grid:
    """The grid for a box in an image of this shape."""
    top, bottom, left, right = box
    scale = 0
    while scale < _COARSEST and ((bottom - top) >> scale) * ((right - left) >> scale) > _BUDGET:
        scale += 1
    stride = 1 << scale
    high, wide = (-(-size // stride) for size in shape)
    first, last = max(top // stride - _MARGIN, 0), min(-(-bottom // stride) + _MARGIN, high)
    begin, end = max(left // stride - _MARGIN, 0), min(-(-right // stride) + _MARGIN, wide)
    rows = np.minimum(np.arange(first, last) * stride + stride // 2, shape[0] - 1)
    cols = np.minimum(np.arange(begin, end) * stride + stride // 2, shape[1] - 1)
    return Grid(scale, first, begin, rows, cols, (first == 0, begin == 0, last == high, end == wide))


def box_of(mask: Mask) -> Box:
    """Box of the true pixels of a mask that has some."""
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return int(rows[0]), int(rows[-1]) + 1, int(cols[0]), int(cols[-1]) + 1


def union(a: Box, b: Box) -> Box:
    """Smallest box that holds two."""
    return min(a[0], b[0]), max(a[1], b[1]), min(a[2], b[2]), max(a[3], b[3])


@compiled
def linked(mask: Mask, seeds: Index) -> Mask:
    """Those true pixels, shape (H, W), that are linked by sides with seeds, shape (N, 2)."""
    rows, cols = mask.shape
    found = np.zeros((rows, cols), np.bool_)
    waiting = np.empty(rows * cols, np.int64)
    count = 0
    for k in range(len(seeds)):
        r, c = seeds[k, 0], seeds[k, 1]
        if mask[r, c] and not found[r, c]:
            found[r, c] = True
            waiting[count] = r * cols + c
            count += 1
    _spread(mask, found, waiting, count)
    return found


@compiled
def without_holes(mask: Mask, outside: Index) -> Mask:
    """The true pixels of a mask, shape (H, W), and what they enclose, but for holes that hold a pixel of `outside`."""
    rows, cols = mask.shape
    free = ~mask
    open_ = np.zeros((rows, cols), np.bool_)
    waiting = np.empty(rows * cols, np.int64)
    count = 0
    for r in range(rows):
        for c in range(cols):
            if (r == 0 or c == 0 or r == rows - 1 or c == cols - 1) and free[r, c]:
                open_[r, c] = True
                waiting[count] = r * cols + c
                count += 1
    for k in range(len(outside)):
        r, c = outside[k, 0], outside[k, 1]
        if free[r, c] and not open_[r, c]:
            open_[r, c] = True
            waiting[count] = r * cols + c
            count += 1
    _spread(free, open_, waiting, count)
    return ~open_


@compiled
def _spread(mask: Mask, found: Mask, waiting: Index, count: int) -> None:
    rows, cols = mask.shape
    while count > 0:
        count -= 1
        r, c = waiting[count] // cols, waiting[count] % cols
        for k in range(4):
            y, x = r + (k == 0) - (k == 1), c + (k == 2) - (k == 3)
            if 0 <= y < rows and 0 <= x < cols and mask[y, x] and not found[y, x]:
                found[y, x] = True
                waiting[count] = y * cols + x
                count += 1
