"""Eq. (9) summed pair by pair, and the usual size of the forces, from a sample of such sums."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import reordered
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index

SAME_SPOT = 1e-36
"""Squared distance up to which two particles are at the same position. Such a pair, and a particle with itself, counts
as one unit apart but for its vanishing distance, so that its force vanishes; without a branch the loop runs on vector
registers. Positions are within some units here, where no two different ones are that near."""

_WORTH_A_THREAD = 100_000
"""Pairs from which a thread pays."""

_SAMPLES, _KEPT = 32, 24
"""Particles of the sample, and how many of them count: those with the smallest forces."""

_ROUNDING = 0.1
"""Fraction of the tolerance that rounding may use."""


def pair_sums(y: Array, x: Array, targets: Index, single: bool) -> Array:
    """Sums of eq. (9) for the particles `targets`, shape (M,), from all the others, shape (M, 2).

    The coordinates y and x, shape (N,), are within some units from zero. With `single`, distances are still computed in
    double precision, so that the error of each pair is 2e-7 of its force everywhere.
    """
    force = np.empty((len(targets), 2))
    least = _WORTH_A_THREAD // max(len(y), 1) + 1
    share(lambda first, last: _sum_pairs(y, x, targets, single, first, last, force), len(targets), least)
    return force


@reordered
def _sum_pairs(y: Array, x: Array, targets: Index, single: bool, first: int, last: int, force: Array) -> None:
    for n in range(first, last):
        force[n, 0], force[n, 1] = pairs_of(y, x, y[targets[n]], x[targets[n]], single)


@reordered
def pairs_of(y: Array, x: Array, y_i: float, x_i: float, single: bool) -> tuple[float, float]:
    """Eq. (9) for a particle at (y_i, x_i) and others, which may be given in any unit of length and include itself."""
    if single:
        one = np.float32(1.0)
        s_y, s_x = one - one, one - one
        for j in range(y.size):
            e_y, e_x = np.float32(y_i - y[j]), np.float32(x_i - x[j])
            near = e_y * e_y + e_x * e_x
            inverse_root = one / np.sqrt(near if near > 0.0 else one)
            weight = inverse_root * inverse_root * inverse_root
            s_y += weight * e_y
            s_x += weight * e_x
        if np.isfinite(s_y) and np.isfinite(s_x):
            return np.float64(s_y), np.float64(s_x)
        # Another particle is so near that its force exceeds single precision.
    f_y, f_x = 0.0, 0.0
    for j in range(y.size):
        d_y, d_x = y_i - y[j], x_i - x[j]
        squared = d_y * d_y + d_x * d_x
        squared = squared if squared > SAME_SPOT else 1.0
        # A root in single precision and a correction are as exact as a root in double precision, and take less time.
        root = np.float64(np.float32(1.0) / np.sqrt(np.float32(squared)))
        rest = 1.0 - squared * root * root
        root *= 1.0 + rest * (0.5 + 0.375 * rest)
        cube = root * root * root
        f_y += cube * d_y
        f_x += cube * d_x
    return f_y, f_x


def usual_force(y: Array, x: Array, tolerance: float) -> tuple[float, bool]:
    """Usual size of the forces, from a sample of particles, and whether single precision is enough for them.

    The size is the root of the mean square of the forces on 32 particles without the largest quarter, so that a few
    that nearly touch do not hide the others. Single precision is enough if the error of `pair_sums` there is at most a
    tenth of the tolerance. It is not where most of the forces on a particle cancel, as on a ring. The coordinates y and
    x, shape (N,), are on the unit square.
    """
    step = np.arange(_SAMPLES)
    # The golden ratio avoids a sample that follows a regular pattern of the particles.
    chosen = ((step + 0.618034 * step % 1.0) * len(y) / _SAMPLES).astype(np.int64)
    exact = pair_sums(y, x, chosen, single=False)
    size = (exact**2).sum(axis=1)
    error = ((pair_sums(y, x, chosen, single=True) - exact) ** 2).sum(axis=1)
    kept = np.argsort(size, kind="stable")[:_KEPT]
    usual = float(np.sqrt(size[kept].mean()))
    return usual, bool(np.sqrt(error[kept].mean()) <= _ROUNDING * tolerance * usual)
