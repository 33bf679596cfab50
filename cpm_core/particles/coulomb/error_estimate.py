"""What forces are usual among some particles, from a sample of them."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.types import Array
from cpm_core.particles.coulomb.direct_sum import pair_sums

_SAMPLES = 32
_KEPT = 24
_ROUNDING = 0.1
"""Part of the tolerance that rounding may take."""


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
