"""Equilibrium: eq. (23), and the other conditions under which a run may stop."""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array
from cpm_core.particles.state import MEMORY

EPSILON = 0.001
"""Bound of eq. (23) [px]."""

QUIET_STEPS = 20
"""Consecutive quiet steps of an equilibrium."""

IDLE_STEPS = 10
"""Steps without newly covered cells after which a coarser scale is finished."""

STILL = 0.02
"""Motion in a step under which a particle does not count as moving [px]."""

_CHURN = 0.002
"""Fraction of the particles that may move, be inserted or be deleted in a quiet step."""

_GROWTH = 0.003
"""Fraction of the coverage that a step must add to count as progress."""


def epsilon(distance: Array) -> float:
    """Left side of eq. (23), ``|sum_i (-1)^i sum_j |r_j(t_k-i)|| / N`` [px].

    `distance`, shape (N, T), is ``|r|`` of every particle at the last T steps, newest first. Rows with NaN do not
    count: their particles are too young. NaN if no particle is T steps old.
    """
    total, old = _alternating(distance)
    return abs(total) / old if old else float("nan")


@compiled
def _alternating(distance: Array) -> tuple[float, int]:
    """Sum of the alternating sums of all rows without NaN, and the number of these rows."""
    total, old = 0.0, 0
    for i in range(len(distance)):
        if not np.isnan(distance[i, MEMORY - 1]):
            for t in range(MEMORY):
                total += distance[i, t] if t % 2 else -distance[i, t]
            old += 1
    return total, old


def is_quiet(epsilon: float, moving: int, changed: int, count: int) -> bool:
    """Whether few of `count` particles moved or changed in a step; `epsilon` is that of eq. (23) [px]."""
    few = _CHURN * count
    return epsilon < EPSILON and moving <= few and changed <= few


def is_idle(new: int, coverage: int) -> bool:
    """Whether a step newly covered next to no cells, compared with the covered cells so far."""
    return new <= _GROWTH * coverage
