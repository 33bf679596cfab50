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

    The positions, shape (N, 3), are within some units from zero. The time grows with the product of the numbers.
    """
    sites = np.ascontiguousarray(points.T)
    force = np.empty((len(targets), 3))
    least = _WORTH_A_THREAD // max(len(points), 1) + 1
    share(lambda first, last: _sum_pairs(sites, targets, first, last, force), len(targets), least)
    return force


@reordered
def _sum_pairs(sites: Array, targets: Index, first: int, last: int, force: Array) -> None:
    for n in range(first, last):
        i = targets[n]
        here = sites[0, i], sites[1, i], sites[2, i]
        force[n, 0], force[n, 1], force[n, 2] = pairs_in_space(sites, 0, sites.shape[1], here[0], here[1], here[2])


@reordered
def pairs_in_space(sites: Array, first: int, last: int, z: float, y: float, x: float) -> tuple[float, float, float]:
    """Eq. (9) for a particle at (z, y, x) and some of the others, shape (3, N), which may include itself."""
    f_z, f_y, f_x = 0.0, 0.0, 0.0
    for j in range(first, last):
        d_z, d_y, d_x = z - sites[0, j], y - sites[1, j], x - sites[2, j]
        squared = d_z * d_z + d_y * d_y + d_x * d_x
        squared = squared if squared > SAME_SPOT else 1.0
        weight = 1.0 / (squared * np.sqrt(squared))
        f_z += weight * d_z
        f_y += weight * d_y
        f_x += weight * d_x
    return f_z, f_y, f_x
