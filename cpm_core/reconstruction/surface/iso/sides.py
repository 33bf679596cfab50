"""Which voxels away from the particles lie inside: each region by the majority of the voxels around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.jit import compiled, inlined
from cpm_core.numerics.runs import runs_of
from cpm_core.numerics.types import Index, Single

FAR = 4.0
"""Height inside, and less than zero outside, of voxels away from all particles."""


def fill_regions(height: Single) -> None:
    """Replace NaN in a height by `FAR` or its negative, region by region; infinite heights belong to no region."""
    regions = runs_of(np.isnan(height), corners=False)
    votes = np.zeros(regions.count, np.int64)
    _vote(height, regions.begin, regions.first, regions.last, regions.part, votes)
    _fill(height, regions.begin, regions.first, regions.last, np.where(votes > 0, FAR, -FAR)[regions.part])


@inlined
def _side(height: float) -> int:
    """1 inside, -1 outside, 0 where it is not known, or infinite."""
    if np.isnan(height) or np.isinf(height):
        return 0
    return 1 if height > 0.0 else -1


@compiled
def _vote(
    height: Single,
    begin: Index,
    first: NDArray[np.int32],
    last: NDArray[np.int32],
    part: Index,
    votes: Index,
) -> None:
    planes, rows, cols = height.shape
    for p in range(planes):
        for r in range(rows):
            for k in range(begin[p * rows + r], begin[p * rows + r + 1]):
                vote = 0
                for c in range(first[k], last[k]):
                    for side in range(4):
                        q, s = p + (side == 0) - (side == 1), r + (side == 2) - (side == 3)
                        if 0 <= q < planes and 0 <= s < rows:
                            vote += _side(height[q, s, c])
                if first[k] > 0:
                    vote += _side(height[p, r, first[k] - 1])
                if last[k] < cols:
                    vote += _side(height[p, r, last[k]])
                votes[part[k]] += vote


@compiled
def _fill(
    height: Single, begin: Index, first: NDArray[np.int32], last: NDArray[np.int32], value: NDArray[np.float64]
) -> None:
    rows = height.shape[1]
    for line in range(len(begin) - 1):
        for k in range(begin[line], begin[line + 1]):
            for c in range(first[k], last[k]):
                height[line // rows, line % rows, c] = value[k]
