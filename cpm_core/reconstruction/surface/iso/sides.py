"""Which voxels away from the particles lie inside: each region by the majority of the voxels around it."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.grids import parts_of
from cpm_core.numerics.types import Single

FAR = 4.0
"""Height inside, and less than zero outside, of voxels away from all particles."""


def fill_regions(height: Single) -> None:
    """Replace NaN in a height by `FAR` or its negative, region by region; infinite heights belong to no region."""
    unknown = np.isnan(height)
    regions = parts_of(unknown, corners=False)
    side = np.where(np.isfinite(height), np.where(height > 0.0, 1, -1), 0).astype(np.int8)
    around = np.zeros_like(side)
    for axis in range(3):
        found, near = np.moveaxis(around, axis, 0), np.moveaxis(side, axis, 0)
        found[1:] += near[:-1]
        found[:-1] += near[1:]
    votes = np.bincount(regions.labels[unknown], around[unknown], minlength=regions.count + 1)
    height[unknown] = np.where(votes > 0, FAR, -FAR)[regions.labels[unknown]]
