"""The direct part of PPPM: what the error function leaves of the potential of near charges, eq. (17)."""

from __future__ import annotations

import math
from functools import reduce

import numpy as np
import scipy

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Mask

_WORTH_A_THREAD = 1_000_000
"""Pairs from which a thread pays."""


def summed_pairs(f: Array, cutoff: float, sigma: float) -> Array:
    r"""Minus the gradient of ``-f (1 - erf(R / sigma)) / R``, summed over all other charges up to the cut-off [px].

    `f` is the edge strength, shape (\*shape), of two or three axes; the result has the shape (D, \*shape).
    """
    reach = [min(int(cutoff), n - 1) for n in f.shape]
    offsets = np.indices([2 * r + 1 for r in reach], float) - np.reshape(reach, (-1, *[1] * f.ndim))
    distance = reduce(np.hypot, offsets)
    away = np.where(distance > 0.0, distance, np.inf)
    slope = (
        scipy.special.erfc(away / sigma) / away**2
        + 2.0 / (math.sqrt(math.pi) * sigma) * np.exp(-((away / sigma) ** 2)) / away
    )
    pulls = np.where(distance <= cutoff, slope / away, 0.0) * offsets
    if f.ndim == 2:
        f, pulls = f[None], pulls[:, None]  # an image is a volume of one plane
    f = np.ascontiguousarray(f)
    out = np.zeros((len(pulls), *f.shape))
    lines = f.shape[0] * f.shape[1]
    charged = np.asarray(f.any(axis=2))
    least = _WORTH_A_THREAD // (pulls.size * f.shape[2]) + 1
    share(lambda first, last: _sum_near(f, charged, pulls, first, last, out), lines, least)
    return out if len(pulls) == 3 else out[:, 0]


@compiled
def _sum_near(f: Array, charged: Mask, pulls: Array, first: int, last: int, out: Array) -> None:
    """Add the force of every charge within the table to some lines of a volume; charges themselves have zeros there."""
    planes, rows, cols = f.shape
    deep, high, wide = pulls.shape[1] // 2, pulls.shape[2] // 2, pulls.shape[3] // 2
    for line in range(first, last):
        p, r = line // rows, line % rows
        for axis in range(pulls.shape[0]):
            found = out[axis, p, r]
            for dp in range(max(-deep, -p), min(deep, planes - 1 - p) + 1):
                for dr in range(max(-high, -r), min(high, rows - 1 - r) + 1):
                    if charged[p + dp, r + dr]:
                        for dc in range(-wide, wide + 1):
                            pull = pulls[axis, deep + dp, high + dr, wide + dc]
                            if pull != 0.0:
                                begin, end = max(0, -dc), min(cols, cols - dc)
                                near = f[p + dp, r + dr, begin + dc : end + dc]
                                for c in range(end - begin):
                                    found[begin + c] += pull * near[c]
