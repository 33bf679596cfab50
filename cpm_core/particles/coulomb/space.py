"""Eq. (9) in space, summed pair by pair in double precision."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import reordered
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index
from cpm_core.particles.coulomb.direct_sum import SAME_SPOT

_WORTH_A_THREAD = 100_000
"""Pairs from which a thread pays."""


def space_sums(points: Array, targets: Index) -> Array:
    """Sums of eq. (9) for the particles `targets`, shape (M,), from all the others, shape (M, 3).

    The time grows with the product of their numbers: 25,000 particles take some seconds.
    """
    extent = float(np.ptp(points, axis=0).max())
    if not np.isfinite(extent):
        raise ValueError("positions must be finite numbers; there are others among them, or they lie too far apart.")
    scale = float(2.0 ** np.floor(np.log2(extent))) if extent > 0.0 else 1.0
    z, y, x = (np.ascontiguousarray(points[:, axis] / scale) for axis in range(3))
    force = np.empty((len(targets), 3))
    least = _WORTH_A_THREAD // max(len(z), 1) + 1
    share(lambda first, last: _sum_pairs(z, y, x, targets, first, last, force), len(targets), least)
    force /= scale
    force /= scale
    return force


@reordered
def _sum_pairs(z: Array, y: Array, x: Array, targets: Index, first: int, last: int, force: Array) -> None:
    for n in range(first, last):
        i = targets[n]
        f_z, f_y, f_x = 0.0, 0.0, 0.0
        for j in range(z.size):
            d_z, d_y, d_x = z[i] - z[j], y[i] - y[j], x[i] - x[j]
            squared = d_z * d_z + d_y * d_y + d_x * d_x
            squared = squared if squared > SAME_SPOT else 1.0
            weight = 1.0 / (squared * np.sqrt(squared))
            f_z += weight * d_z
            f_y += weight * d_y
            f_x += weight * d_x
        force[n, 0], force[n, 1], force[n, 2] = f_z, f_y, f_x
