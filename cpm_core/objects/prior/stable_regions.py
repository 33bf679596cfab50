"""Stable regions: what is connected to a point and has about its gray level, whatever the network says."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from cpm_core.numerics.types import Mask
from cpm_core.objects.prior.crops import CROP_SIDE
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
    step = tuple(np.clip(np.rint(context.positive[0]), 0, CROP_SIDE - 1).astype(int).tolist())
    grays = scipy.ndimage.gaussian_filter(context.grays, 1.0)
    difference = np.abs(grays - grays[step])
    for axis, (first, last) in enumerate(context.inner_steps.tolist()):
        slices = np.moveaxis(difference, axis, 0)
        slices[:first], slices[last + 1 :] = np.inf, np.inf
    regions: list[Mask] = []
    sizes: list[int] = []
    for tolerance in _GRAY_TOLERANCES:
        near = difference < tolerance
        numbers, _ = scipy.ndimage.label(scipy.ndimage.binary_erosion(near, border_value=1))
        core = (numbers == numbers[step]) & (numbers[step] > 0)
        regions.append(scipy.ndimage.binary_dilation(core, iterations=2) & near)
        sizes.append(max(int(core.sum()), 1))
    growth = np.diff(np.log(sizes))
    beside = np.pad(growth, 1, constant_values=_MAX_STABLE_GROWTH)
    is_stable = (growth <= beside[:-2]) & (growth < beside[2:]) & (np.array(sizes[:-1]) > 1)
    yield from (regions[number] for number in np.flatnonzero(is_stable).tolist())
