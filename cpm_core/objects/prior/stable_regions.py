"""Stable regions: what is connected to a point and has about its gray level, whatever the network says."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from cpm_core.numerics.grids import nearest_pixels
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Index, Mask, Single
from cpm_core.objects.prior.volume_slices import CropContext

_GRAY_TOLERANCES = 8.0 * 1.25 ** np.arange(12)
"""Differences from the gray level of a point."""

_MAX_STABLE_GROWTH = 0.2
"""Largest growth of the logarithm of a volume from one tolerance to the next where it is stable."""


def find_stable_regions(context: CropContext) -> Iterator[Mask]:
    """Find regions connected to the first positive point whose gray levels differ little from its own.

    Only those tolerances count at which the region hardly grows (maximally stable regions: Matas et al. 2004,
    doi:10.1016/j.imavis.2004.02.006). Bridges narrower than three steps are cut. Yields masks, shape
    (CROP_SIDE, CROP_SIDE, CROP_SIDE).
    """
    step = tuple(nearest_pixels(context.positive[0], context.grays.shape).tolist())
    grays = scipy.ndimage.gaussian_filter(context.grays, 1.0)
    difference = np.abs(grays - grays[step])
    for axis, (first, last) in enumerate(context.inner_steps.tolist()):
        slices = np.moveaxis(difference, axis, 0)
        slices[:first], slices[last + 1 :] = np.inf, np.inf
    rank = np.searchsorted(_GRAY_TOLERANCES, _find_largest_beside(difference), side="right").astype(np.int64)
    joined = np.full(rank.shape, len(_GRAY_TOLERANCES), np.int64)
    _join_by_rank(rank.ravel(), int(np.ravel_multi_index(step, rank.shape)), joined.reshape(-1))
    sizes = np.cumsum(np.bincount(joined.ravel(), minlength=len(_GRAY_TOLERANCES) + 1))[:-1]
    growth = np.diff(np.log(np.maximum(sizes, 1)))
    beside = np.pad(growth, 1, constant_values=_MAX_STABLE_GROWTH)
    is_stable = (growth <= beside[:-2]) & (growth < beside[2:]) & (sizes[:-1] > 1)
    for number in np.flatnonzero(is_stable).tolist():
        core = scipy.ndimage.binary_dilation(joined <= number, iterations=2)
        yield core & (difference < _GRAY_TOLERANCES[number])


def _find_largest_beside(values: Single) -> Single:
    """Find the largest of the values at each step and at its six neighbors."""
    largest = values.copy()
    for axis in range(3):
        there, here = np.moveaxis(largest, axis, 0), np.moveaxis(values, axis, 0)
        np.maximum(there[1:], here[:-1], out=there[1:])
        np.maximum(there[:-1], here[1:], out=there[:-1])
    return largest


@compiled
def _join_by_rank(rank: Index, start: int, joined: Index) -> None:
    """Find the rank at which each step of a crop is joined to a start by steps of no higher rank.

    `rank` and `joined` are cubes as one row; where `joined` is not reached it stays as it is, at the number of ranks.
    """
    side = round(len(rank) ** (1.0 / 3.0))
    count = joined[start]
    first, following = np.full(count, -1), np.full(len(rank), -1)
    if rank[start] < count:
        first[rank[start]] = start
        joined[start] = rank[start]
    for number in range(count):
        while first[number] >= 0:
            at = first[number]
            first[number] = following[at]
            place = at // (side * side), at // side % side, at % side
            for axis in range(3):
                stride = side ** (2 - axis)
                for way in (-1, 1):
                    if 0 <= place[axis] + way < side:
                        beside = at + way * stride
                        if joined[beside] == count and rank[beside] < count:
                            joined[beside] = max(rank[beside], number)
                            following[beside] = first[joined[beside]]
                            first[joined[beside]] = beside
