"""Description: what is known of the object that a drawn start may mean, next to `features.OBJECT`.

The edge along the boundary is told by its strength here, not by its rank, and what surrounds the object is looked at up
to a distance that grows with it; the shape is compared with its convex hull.
"""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask, Pixels, Single
from cpm_core.objects.candidates.appearance import BINS, Appearance
from cpm_core.objects.candidates.features import along_boundary, distance
from cpm_core.objects.candidates.grids import Grid

DESCRIPTION = (
    "strength", "faint", "overlap", "far step", "far contrast", "sign", "solidity", "elongation", "margin",
)  # fmt: skip
"""Logarithm of the mean strength of the edge along the boundary; share of the boundary where it is weak; logarithm of
how far the histogram of the object's gray levels parts from that of its surroundings; logarithms of the difference of
the means, over the deviation of the image and over both deviations; 1 for a light object and -1 for a dark one; share
of the convex hull, and ratio of the axes, as logarithms; and logarithm of the depth of the middle of the start,
in radii of the drawn circle."""

_FAINT = 0.3
"""Strength of a weak edge, as a fraction of the strong one."""

_AROUND, _LEAST_AROUND = np.float32(0.35), np.float32(4.0)
"""Width of the surroundings, in radii of a disk of the same area; and the least [points of the grid]."""


def description(look: Appearance, grid: Grid, mask: Mask, click: Index, strong: float, radius: float) -> Array:
    """Features `DESCRIPTION` of an object, given on a grid.

    Parameters
    ----------
    look : Appearance
        The image.
    grid, mask : Grid, ndarray of bool
        The object.
    click : ndarray of int64, shape (2,)
        Middle of the start.
    strong : float
        Edge strength that counts as strong.
    radius : float
        Radius of the drawn circle [px].
    """
    rows, cols = slice(grid.top, grid.top + len(grid.rows)), slice(grid.left, grid.left + len(grid.cols))
    part = look.resolutions[grid.scale]
    point = grid.nearest(click)
    found = np.zeros(len(DESCRIPTION))
    depth = _describe(
        mask,
        np.ascontiguousarray(part.strength[rows, cols]),
        np.ascontiguousarray(part.gray[rows, cols]),
        np.ascontiguousarray(part.bin[rows, cols]),
        look.deviation,
        max(strong, 1e-300),
        point[0],
        point[1],
        found,
    )
    found[8] = np.log(depth * float(1 << grid.scale) / max(radius, 1.0) + 0.02)
    return found


@compiled
def _describe(
    mask: Mask,
    strength: Single,
    gray: Single,
    bins: Pixels,
    deviation: float,
    strong: float,
    row: int,
    col: int,
    found: Array,
) -> float:
    """Fill in the features except for the last one; the depth of the point in the mask."""
    rows, cols = mask.shape
    away, depth = np.empty((rows, cols), np.float32), np.empty((rows, cols), np.float32)
    distance(mask, False, away)
    distance(mask, True, depth)
    moments, count = np.zeros(5), 0.0
    for r in range(rows):
        for c in range(cols):
            if mask[r, c]:
                count += 1.0
                moments[0] += r
                moments[1] += c
                moments[2] += r * r
                moments[3] += r * c
                moments[4] += c * c
    if count == 0.0:
        return 0.0
    _edges(mask, strength, strong, found)
    width = max(_AROUND * np.float32(np.sqrt(count / np.pi)), _LEAST_AROUND)
    _surroundings(mask, away, width, gray, bins, deviation, found)
    y, x = moments[0] / count, moments[1] / count
    a, b, d = moments[2] / count - y * y, moments[3] / count - y * x, moments[4] / count - x * x
    half = np.sqrt(0.25 * (a - d) ** 2 + b * b)
    found[6] = np.log(count / max(_hull_area(mask), count) + 0.01)
    found[7] = 0.5 * np.log((0.5 * (a + d) + half + 0.1) / (max(0.5 * (a + d) - half, 0.0) + 0.1))
    return float(depth[row, col])


@compiled
def _edges(mask: Mask, strength: Single, strong: float, found: Array) -> None:
    boundary, total, faint = along_boundary(mask, strength, _FAINT * strong)
    found[0] = np.log(total / max(boundary, 1.0) / strong + 0.02)
    found[1] = faint / max(boundary, 1.0)


@compiled
def _surroundings(
    mask: Mask, away: Single, width: np.float32, gray: Single, bins: Pixels, deviation: float, found: Array
) -> None:
    rows, cols = mask.shape
    sums, counts = np.zeros((2, 3)), np.full((2, BINS), 0.05)
    for r in range(rows):
        for c in range(cols):
            if mask[r, c] or away[r, c] <= width:
                side = 0 if mask[r, c] else 1
                value = float(gray[r, c])
                sums[side, 0] += 1.0
                sums[side, 1] += value
                sums[side, 2] += value * value
                counts[side, bins[r, c]] += 1.0
    likeness = 0.0
    inner, outer = sums[0, 0] + 0.05 * BINS, sums[1, 0] + 0.05 * BINS
    for k in range(BINS):
        likeness += np.sqrt(_smoothed(counts[0], k) / inner * _smoothed(counts[1], k) / outer)
    found[2] = np.log(1.02 - min(likeness, 1.0))
    mean = sums[0, 1] / sums[0, 0]
    spread = np.sqrt(max(sums[0, 2] / sums[0, 0] - mean * mean, 0.0))
    other, other_spread = mean, 0.0
    if sums[1, 0] > 0.0:
        other = sums[1, 1] / sums[1, 0]
        other_spread = np.sqrt(max(sums[1, 2] / sums[1, 0] - other * other, 0.0))
    step = abs(mean - other)
    found[3] = np.log(step / deviation + 0.02)
    found[4] = np.log(step / (spread + other_spread + 0.03 * deviation) + 0.02)
    found[5] = 1.0 if mean > other else -1.0


@compiled
def _smoothed(counts: Array, k: int) -> float:
    """A bin of a histogram, smoothed; beyond its ends it continues as at them."""
    last = BINS - 1
    near = counts[max(k - 1, 0)] + counts[min(k + 1, last)]
    far = counts[max(k - 2, 0)] + counts[min(k + 2, last)]
    return float(6.0 * counts[k] + 4.0 * near + far) / 16.0


@compiled
def _hull_area(mask: Mask) -> float:
    """Area of the convex hull of the points of a mask, each a square of side 1."""
    rows, cols = mask.shape
    left, right = np.empty((2 * rows, 2), np.int64), np.empty((2 * rows, 2), np.int64)
    ends = np.zeros(2, np.int64)
    for r in range(rows):
        first, last = -1, -1
        for c in range(cols):
            if mask[r, c]:
                if first < 0:
                    first = c
                last = c
        if first >= 0:
            for corner in range(2):
                ends[0] = _turned(left, ends[0], r + corner, first, 1)
                ends[1] = _turned(right, ends[1], r + corner, last + 1, -1)
    area = 0.0
    for side, (line, end) in enumerate(((left, ends[0]), (right, ends[1]))):
        for k in range(1, end):
            part = 0.5 * (line[k, 1] + line[k - 1, 1]) * (line[k, 0] - line[k - 1, 0])
            area += part if side else -part
    return area


@compiled
def _turned(line: Index, count: int, row: int, col: int, sign: int) -> int:
    """Add a corner to one side of a hull, without those before it that it makes superfluous; the number of corners."""
    while count >= 2:
        turn = (line[count - 1, 0] - line[count - 2, 0]) * (col - line[count - 2, 1]) - (
            line[count - 1, 1] - line[count - 2, 1]
        ) * (row - line[count - 2, 0])
        if turn * sign > 0:
            break
        count -= 1
    line[count, 0], line[count, 1] = row, col
    return count + 1
