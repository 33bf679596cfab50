"""Eq. (9) summed pair by pair, and how large forces usually are, from a sample of such sums."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index

SAME_SPOT = 1e-36
"""Squared distance up to which two particles stand on the same spot. Such a pair, and a particle and itself, is taken
for one that is a unit apart but for its vanishing distance, which pushes nothing; no branch then keeps the loop from
vector registers. Positions are within some units here, where no two that are not the same are that near."""

_WORTH_A_THREAD = 100_000
"""Pairs from which on a thread of its own pays."""

_SAMPLES, _KEPT = 32, 24
"""Particles whose forces are looked at, and how many of them count: those with the smallest ones."""

_ROUNDING = 0.1
"""Part of the tolerance that rounding may take."""


def pair_sums(y: Array, x: Array, targets: Index, single: bool) -> Array:
    """Force on some particles from all the others.

    Parameters
    ----------
    y, x : ndarray, shape (N,)
        Coordinates of the particles, none beyond some units from zero.
    targets : ndarray of int64, shape (M,)
        Indices of the particles whose force is wanted.
    single : bool
        Whether single precision is enough: distances are still taken in double precision, so that the force of each
        pair is right to 2e-7 of its size wherever the particles are.

    Returns
    -------
    ndarray, shape (M, 2)
        Sums of eq. (9).
    """
    force = np.empty((len(targets), 2))
    least = _WORTH_A_THREAD // max(len(y), 1) + 1
    share(lambda first, last: _sum_pairs(y, x, targets, single, first, last, force), len(targets), least)
    return force


@compiled
def _sum_pairs(y: Array, x: Array, targets: Index, single: bool, first: int, last: int, force: Array) -> None:
    for n in range(first, last):
        force[n, 0], force[n, 1] = pairs_of(y, x, y[targets[n]], x[targets[n]], single)


@compiled
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
        # Another is so near that single precision has no number for its push.
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
    """Size of the forces on a sample of particles, and whether single precision is enough for them.

    Parameters
    ----------
    y, x : ndarray, shape (N,)
        Coordinates of the particles, on the unit square.
    tolerance : float
        Relative error that is allowed.

    Returns
    -------
    tuple of float and bool
        Root of the mean square of the forces on 32 particles without the largest quarter, so that a few that nearly
        touch do not hide the others; and whether the sums of `pair_sums` in single precision were right there to a
        tenth of the tolerance. They are not where most of what acts on a particle cancels, as on a ring.
    """
    step = np.arange(_SAMPLES)
    # The golden ratio keeps the sample from falling into step with a pattern of the particles.
    chosen = ((step + 0.618034 * step % 1.0) * len(y) / _SAMPLES).astype(np.int64)
    exact = pair_sums(y, x, chosen, single=False)
    size = (exact**2).sum(axis=1)
    error = ((pair_sums(y, x, chosen, single=True) - exact) ** 2).sum(axis=1)
    kept = np.argsort(size, kind="stable")[:_KEPT]
    usual = float(np.sqrt(size[kept].mean()))
    return usual, bool(np.sqrt(error[kept].mean()) <= _ROUNDING * tolerance * usual)
