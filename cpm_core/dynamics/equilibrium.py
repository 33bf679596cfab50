"""When a run is at rest: eq. (23), and what else must hold before it may stop."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array
from cpm_core.particles.state import MEMORY

EPSILON = 0.001
"""Bound of eq. (23) [px]."""

QUIET_STEPS = 20
"""Consecutive quiet steps that make rest."""

IDLE_STEPS = 10
"""Steps without newly covered cells after which a coarser scale has nothing more to give."""

STILL = 0.02
"""Motion in a step under which a particle counts as still [px]."""

_CHURN = 0.002
"""Fraction of the particles that may move, be born or be deleted in a quiet step."""

_NEWS = 0.003
"""Fraction of the coverage that a step must add to count as finding some."""


def epsilon(distance: Array) -> float:
    """Left side of eq. (23): ``|sum_i (-1)^i sum_j |r_j(t_k-i)|| / N``.

    Parameters
    ----------
    distance : ndarray, shape (N, T)
        ``|r|`` of every particle at the last T steps, newest first; rows with NaN are of particles too young to count.

    Returns
    -------
    float
        The mean difference [px]; NaN without any particle that has been there for T steps.
    """
    total, old = _alternating(distance)
    return abs(total) / old if old else float("nan")


@compiled
def _alternating(distance: Array) -> tuple[float, int]:
    """Sum of the alternating sums of all rows without NaN, and how many they are."""
    total, old = 0.0, 0
    for i in range(len(distance)):
        if not np.isnan(distance[i, MEMORY - 1]):
            for t in range(MEMORY):
                total += distance[i, t] if t % 2 else -distance[i, t]
            old += 1
    return total, old


def is_quiet(epsilon: float, moving: int, changed: int, count: int) -> bool:
    """Whether a step hardly moved, inserted or deleted anything.

    Parameters
    ----------
    epsilon : float
        Eq. (23) [px].
    moving : int
        Particles that moved by more than `STILL`.
    changed : int
        Particles born and deleted.
    count : int
        Particles.
    """
    few = _CHURN * count
    return epsilon < EPSILON and moving <= few and changed <= few


def is_idle(new: int, coverage: int) -> bool:
    """Whether a step covered next to no new cells.

    Parameters
    ----------
    new : int
        Cells visited for the first time.
    coverage : int
        Cells visited so far.
    """
    return new <= _NEWS * coverage
