"""Inner parts of a body: what differs from most of it by more than noise, with an edge too faint for a run."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy

from cpm_core.image.region import Region
from cpm_core.numerics.grids import expand_window, find_largest_part, first_pixel, measure_depth, running_maximum
from cpm_core.numerics.types import Array
from cpm_core.objects.boundaries.background import measure_level

_EDGE_WIDTH = 4
"""Width of the rim of a body in which its own edge is seen [smallest sides of a voxel]."""

_MIN_CORE_DIFFERENCE = 4.0
"""Least difference of an inner part from the median of the body that is no noise [standard deviations]."""

_MIN_CORE_SIZE = 30
"""Least number of voxels of an inner part that differ so [voxels]."""

_HIGH_RANK = 0.9
"""Quantile of differences by which the extent of an inner part is first estimated."""

_EDGE_SIGMA = 0.7
"""Sigma of the Gaussian over gray levels across the edge of an inner part: a wider one moves the edges of small ones
[smallest sides of a voxel]."""

_DEEP_SHARE = 0.5
"""Least depth in an inner part, in its largest, at which its own gray level is none of its blurred rim."""


def find_inner_parts(values: Array, body: Region, sides: Array) -> Iterator[Region]:
    """Find the inner parts of a body, in gray levels of shape (P, R, C) with voxels of these sides.

    Each reaches as far as gray levels are nearer to its own, deep inside, than to that of the body.
    """
    body = body.clipped(values.shape)
    window, inside = body.window, body.mask
    reach = np.ceil(_EDGE_WIDTH / sides).astype(int)
    # boxes instead of balls take a tenth of the time
    inner = ~running_maximum(~np.pad(inside, 1), reach)[1:-1, 1:-1, 1:-1]
    if not inner.any():
        return
    rise = scipy.ndimage.gaussian_filter(values[window], 1.0 / sides, output=np.float32)
    level, noise = measure_level(rise[inner], float(np.ptp(values)))
    rise -= level
    cores = np.empty(rise.shape, np.int32)
    for sign in (1.0, -1.0):  # in place, as bodies may be large
        rise *= sign
        differs = inner & (rise > _MIN_CORE_DIFFERENCE * noise)
        if np.count_nonzero(differs) < _MIN_CORE_SIZE:
            continue
        scipy.ndimage.label(differs, output=cores)
        for number, box in enumerate(scipy.ndimage.find_objects(cores), start=1):
            near = expand_window(box, _EDGE_WIDTH, rise.shape)
            core = cores[near] == number
            if np.count_nonzero(core) >= _MIN_CORE_SIZE:
                around = scipy.ndimage.distance_transform_edt(~core, sides) <= _EDGE_WIDTH
                reach, own = around & inside[near], float(np.quantile(rise[near][core], _HIGH_RANK))
                depth = measure_depth(find_largest_part(reach & (rise[near] > 0.5 * own)), sides)
                fine = scipy.ndimage.gaussian_filter(values[window][near], _EDGE_SIGMA / sides, output=np.float32)
                fine = sign * (fine - level)
                own = float(np.median(fine[depth >= _DEEP_SHARE * depth.max()]))
                part = find_largest_part(reach & (fine > 0.5 * own))
                yield Region.from_mask(part, np.add(body.origin, first_pixel(near)))
