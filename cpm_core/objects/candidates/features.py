"""Features of candidates: the edge around them, their gray levels and those next to them, and where the click lies."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index, Mask, Pixels, Single
from cpm_core.objects.candidates.appearance import Appearance
from cpm_core.objects.candidates.grids import Grid

OBJECT = ("edge", "weak", "depth", "contrast", "texture", "border", "roundness", "step")
"""Features of an object: mean rank of the edge along its boundary; share of the boundary below the rank 3/4; depth of
the first click, as a share of the largest; logarithm of the difference of gray levels to what is around it over both
deviations; mean rank of edges inside; share of the boundary on the border of the image; logarithm of 4 pi A / P^2; and
of that difference over the deviation of the image."""

CHANGE = (
    "depth of click", "new edge", "old edge", "new share", "new contrast", "old contrast", "likeness", "thickness",
    "variation",
)  # fmt: skip
"""Features of a change: depth of the click in it; mean rank of the edge along its new boundary, and along the one that
vanishes; share of the new one; contrast to what is beyond the one and the other; mean logarithm of the likelihood ratio
of its gray levels, positive if they belong to where they come; logarithm of its depth [px]; and of its deviation."""

_WEAK = 0.75
_NEAR, _FAR = np.float32(1.2), np.float32(4.5)
"""What is around a region lies between these distances [points of the grid]."""

_DEEP = np.float32(2.5)
_DIAGONAL = np.float32(1.4)


def object_features(look: Appearance, grid: Grid, mask: Mask, click: Index) -> Array:
    """Features `OBJECT` of an object, given on a grid; `click` is the pixel of the first click."""
    part = _part(look, grid)
    point = grid.nearest(click)
    found = np.empty(len(OBJECT))
    _object(mask, part[0], part[1], point[0], point[1], np.array(grid.at_border), look.deviation, found)
    return found


def change_features(
    look: Appearance, grid: Grid, change: Mask, chosen: Mask, ratio: Array, click: Index, adding: bool
) -> Array:
    """Features `CHANGE` of a change of what was chosen, both given on a grid; `ratio` is that of `log_ratio`."""
    rank, gray, bins = _part(look, grid)
    point = grid.nearest(click)
    found = np.empty(len(CHANGE))
    stride = float(1 << grid.scale)
    _change(change, chosen, adding, rank, gray, bins, ratio, point[0], point[1], look.deviation, stride, found)
    return found


def _part(look: Appearance, grid: Grid) -> tuple[Single, Single, Pixels]:
    rows = slice(grid.top, grid.top + len(grid.rows))
    cols = slice(grid.left, grid.left + len(grid.cols))
    rank, gray, bins, _ = look.resolutions[grid.scale]
    # in one piece, whatever the part: a loop is compiled for each layout of an array
    return (
        np.ascontiguousarray(rank[rows, cols]),
        np.ascontiguousarray(gray[rows, cols]),
        np.ascontiguousarray(bins[rows, cols]),
    )


@compiled
def distance(mask: Mask, value: bool, out: Single) -> None:
    """Distance of each point of this value to the nearest of the other, along sides and diagonals."""
    rows, cols = mask.shape
    one = np.float32(1.0)
    for r in range(rows):
        for c in range(cols):
            if mask[r, c] != value:
                out[r, c] = np.float32(0.0)
                continue
            least = np.float32(1e4)
            if r > 0:
                least = min(least, out[r - 1, c] + one)
                if c > 0:
                    least = min(least, out[r - 1, c - 1] + _DIAGONAL)
                if c < cols - 1:
                    least = min(least, out[r - 1, c + 1] + _DIAGONAL)
            if c > 0:
                least = min(least, out[r, c - 1] + one)
            out[r, c] = least
    for r in range(rows - 1, -1, -1):
        for c in range(cols - 1, -1, -1):
            least = out[r, c]
            if r < rows - 1:
                least = min(least, out[r + 1, c] + one)
                if c > 0:
                    least = min(least, out[r + 1, c - 1] + _DIAGONAL)
                if c < cols - 1:
                    least = min(least, out[r + 1, c + 1] + _DIAGONAL)
            if c < cols - 1:
                least = min(least, out[r, c + 1] + one)
            out[r, c] = least


@compiled
def _object(
    mask: Mask, rank: Single, gray: Single, row: int, col: int, at_border: Mask, deviation: float, found: Array
) -> None:
    rows, cols = mask.shape
    depth, away = np.empty((rows, cols), np.float32), np.empty((rows, cols), np.float32)
    distance(mask, True, depth)
    distance(mask, False, away)
    border = _end_at_border(mask, at_border, depth)
    inner, around = np.zeros(3), np.zeros(3)
    ranks, deep, deepest = 0.0, np.zeros(2), np.float32(0.0)
    for r in range(rows):
        for c in range(cols):
            if mask[r, c]:
                _add(inner, gray[r, c])
                ranks += rank[r, c]
                deepest = max(deepest, depth[r, c])
                if depth[r, c] > _DEEP:
                    deep[0] += 1.0
                    deep[1] += rank[r, c]
            elif _NEAR < away[r, c] <= _FAR:
                _add(around, gray[r, c])
    for k in range(len(found)):
        found[k] = 0.0
    if inner[0] == 0.0:
        return
    boundary, edges, weak = along_boundary(mask, rank, _WEAK)
    mean, spread = _moments(inner)
    other, other_spread = (mean, spread) if around[0] <= 3.0 else _moments(around)
    step, perimeter = abs(mean - other), boundary + border + 1e-9
    found[0] = edges / max(boundary, 1.0)
    found[1] = weak / max(boundary, 1.0)
    found[2] = depth[row, col] / deepest if mask[row, col] else 0.0
    found[3] = np.log(step / (spread + other_spread + 0.03 * deviation) + 0.02)
    found[4] = deep[1] / deep[0] if deep[0] > 8.0 else ranks / inner[0]
    found[5] = border / perimeter
    found[6] = np.log(4.0 * np.pi * inner[0] / perimeter**2 + 0.01)
    found[7] = np.log(step / deviation + 0.02)


@compiled
def _end_at_border(mask: Mask, at_border: Mask, depth: Single) -> float:
    """Let the depth end at the border of the image; the number of sides of pixels there."""
    rows, cols = mask.shape
    border = 0.0
    for r in range(rows):
        for c in range(cols):
            if mask[r, c]:
                sides = (r + 1, c + 1, rows - r, cols - c)
                for k in range(4):
                    if at_border[k]:
                        depth[r, c] = min(depth[r, c], np.float32(sides[k]))
                        border += sides[k] == 1
    return border


@compiled
def along_boundary(mask: Mask, rank: Single, weakest: float) -> tuple[float, float, float]:
    """Points of a mask next to others; the sum of the strongest rank at each; and the number of those below another."""
    rows, cols = mask.shape
    boundary, edges, weak = 0.0, 0.0, 0.0
    for r in range(rows):
        for c in range(cols):
            if not mask[r, c]:
                continue
            strongest, outer = rank[r, c], 0
            for k in range(4):
                y, x = r + (k == 0) - (k == 1), c + (k == 2) - (k == 3)
                if 0 <= y < rows and 0 <= x < cols and not mask[y, x]:
                    strongest, outer = max(strongest, rank[y, x]), outer + 1
            if outer:
                boundary += 1.0
                edges += strongest
                weak += strongest < weakest
    return boundary, edges, weak


@compiled
def _change(
    change: Mask,
    chosen: Mask,
    adding: bool,
    rank: Single,
    gray: Single,
    bins: Pixels,
    ratio: Array,
    row: int,
    col: int,
    deviation: float,
    stride: float,
    found: Array,
) -> None:
    rows, cols = change.shape
    depth, away = np.empty((rows, cols), np.float32), np.empty((rows, cols), np.float32)
    distance(change, True, depth)
    distance(change, False, away)
    inner, beyond, behind = np.zeros(3), np.zeros(3), np.zeros(3)
    likeness, deepest = 0.0, np.float32(0.0)
    for r in range(rows):
        for c in range(cols):
            if change[r, c]:
                _add(inner, gray[r, c])
                likeness += ratio[bins[r, c]]
                deepest = max(deepest, depth[r, c])
            elif away[r, c] <= _FAR:
                _add(behind if chosen[r, c] == adding else beyond, gray[r, c])
    for k in range(len(found)):
        found[k] = 0.0
    if inner[0] == 0.0:
        return
    new, old = _ends(change, chosen, adding, rank)
    mean, spread = _moments(inner)
    found[0] = depth[row, col] / deepest if change[row, col] else 0.0
    found[1] = new[1] / new[0] if new[0] > 0.0 else 0.5
    found[2] = old[1] / old[0] if old[0] > 0.0 else 0.5
    found[3] = new[0] / (new[0] + old[0] + 1.0)
    for k, beside in enumerate((beyond, behind)):
        if beside[0] > 3.0:
            other, other_spread = _moments(beside)
            found[4 + k] = np.log(abs(mean - other) / (spread + other_spread + 0.03 * deviation) + 0.02)
    found[6] = likeness / inner[0] * (1.0 if adding else -1.0)
    found[7] = np.log(deepest * stride + 0.5)
    found[8] = np.log(spread / deviation + 0.02)


@compiled
def _ends(change: Mask, chosen: Mask, adding: bool, rank: Single) -> tuple[Array, Array]:
    """Number of sides of a change on its new boundary, and on the old one, and the sums of the ranks there."""
    rows, cols = change.shape
    new, old = np.zeros(2), np.zeros(2)
    for r in range(rows):
        for c in range(cols):
            if not change[r, c]:
                continue
            for k in range(4):
                y, x = r + (k == 0) - (k == 1), c + (k == 2) - (k == 3)
                if 0 <= y < rows and 0 <= x < cols and not change[y, x]:
                    side = old if chosen[y, x] == adding else new
                    side[0] += 1.0
                    side[1] += max(rank[r, c], rank[y, x])
    return new, old


@compiled
def _add(sums: Array, value: float) -> None:
    sums[0] += 1.0
    sums[1] += value
    sums[2] += value * value


@compiled
def _moments(sums: Array) -> tuple[float, float]:
    """Mean and standard deviation by number, sum, and sum of squares."""
    mean = sums[1] / sums[0]
    return mean, np.sqrt(max(sums[2] / sums[0] - mean * mean, 0.0))
