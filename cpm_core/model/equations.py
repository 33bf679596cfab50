"""The laws of motion of a particle: total force of eq. (12) and one step of eq. (14)-(15), and equilibrium, eq. (23).

The laws are functions of single numbers, for the loops that apply them to every particle, in any number of dimensions.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from cpm_core.model.state import HISTORY_STEPS
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array
from cpm_core.parameters import UNLIMITED_REACH, Parameters

COULOMB_SOFTNESS = 0.5
"""Slope of the normalized Coulomb force near equilibrium; with it the integrator keeps the stiffest mode of a chain of
particles, neighbors moving against each other, stable at the default time step."""

_STICTION_FORCE = 0.25
"""Largest force along an edge, as a fraction of w1, under which a particle on it stays at rest."""

_STICTION_GROWTH = 0.02
"""Growth of that force for each step without newly covered cells."""

_FADING_PER_STEP = 0.04
"""Fraction of the repulsion that is lost for each step without newly covered cells."""

_DAMPING_DOUBLING_STEPS = 12.0
"""Steps in which damping doubles once the repulsion has faded."""

_MAX_DOUBLING_STEPS = 200.0
"""Steps during which damping continues to double."""

_MIN_LATE_DAMPING = 0.1
"""Least damping from which the doubling starts."""

FADED_STEPS = round(1.0 / _FADING_PER_STEP)
"""Steps without newly covered cells after which no repulsion is left."""

FINAL_DAMPING_STEPS = FADED_STEPS + int(_MAX_DOUBLING_STEPS)
"""Steps without newly covered cells after which the damping is constant."""

_STUCK_SPEED = 0.3
"""Largest speed along an edge at which static friction acts [px / unit of time]."""


@compiled
def coulomb_scale(size: float, spacing: float, d_min: float) -> float:
    """Return the factor that normalizes the Coulomb force: unit size on a sparse front, zero near equilibrium.

    The unit vector of the sum never comes to rest: its direction flips around equilibrium. Scaled by the squared local
    spacing the sum is a pure number, of order one on a particle with neighbors on one side only and small where they
    balance; only what exceeds one is cut. `size` is the length of the sum of eq. (9), `spacing` the mean distance to
    the two nearest particles [px]; below `d_min` [px] the force softens further.
    """
    scale = COULOMB_SOFTNESS * spacing**2 * min(1.0, spacing / d_min)
    scale /= max(1.0, size * scale)
    return scale


@compiled
def repulsion_left(idle: int) -> float:
    """Return the fraction of the Coulomb force left, from 1 to 0, `idle` steps after cells nearby were newly covered.

    As long as coverage grows the repulsion is not reduced. Afterwards it could only make particles creep, on edges from
    bays to tips and off edges against those on them, so it fades, and all particles reach an edge and come to rest.
    """
    return max(0.0, 1.0 - _FADING_PER_STEP * idle)


def damping_coefficient(beta: float, idle: int) -> float:
    """Return the damping coefficient of a particle: beta, and more for large `idle`.

    `idle` are the steps since cells around it were newly covered.

    A particle that still moves without repulsion follows the field where there is no edge. The growing damping brings
    it to rest.
    """
    late = min(max(idle - float(FADED_STEPS), 0.0), _MAX_DOUBLING_STEPS)
    return max(beta, _MIN_LATE_DAMPING) * 2.0 ** (late / _DAMPING_DOUBLING_STEPS) if late > 0.0 else beta


@lru_cache(maxsize=8)
def damped_motion(beta: float, dt: float) -> Array:
    """Return the series of the damped motion by the steps without newly covered cells; the last row is for later ones.

    This is the damping ``-beta v`` of eq. (12), integrated in closed form; ``beta = 0`` gives eq. (14).
    """
    return np.array([damped_series(damping_coefficient(beta, idle) * dt) for idle in range(FINAL_DAMPING_STEPS + 1)])


def damped_series(z: float) -> tuple[float, float, float, float]:
    """Return ``exp(-z)`` and the weights that damping ``z = beta dt`` leaves of 1, 1/2 and 1/6 in eq. (14)."""
    keep = math.exp(-z)
    if z < 1e-2:  # the closed forms cancel for small z; the series are exact to rounding there
        one = 1.0 - z / 2.0 + z**2 / 6.0 - z**3 / 24.0 + z**4 / 120.0
        two = 0.5 - z / 6.0 + z**2 / 24.0 - z**3 / 120.0 + z**4 / 720.0
        three = 1.0 / 6.0 - z / 24.0 + z**2 / 120.0 - z**3 / 720.0 + z**4 / 5040.0
        return keep, one, two, three
    one = -math.expm1(-z) / z
    two = (1.0 - one) / z
    return keep, one, two, (0.5 - two) / z


@compiled
def advance_coordinate(
    place: float,
    velocity: float,
    force: float,
    last: float,
    before: float,
    dt: float,
    series: tuple[float, float, float, float],
) -> tuple[float, float]:
    """Return position and velocity of one coordinate of a particle after a time step, eq. (14)-(15).

    The undamped force is continued by its Taylor series, whose derivative is eq. (15): the quadratic through the last
    three forces ``w1 F_c + w2 F_l``, now and at the two steps before. Damping is linear and therefore integrated
    exactly, which keeps every beta stable; as beta goes to zero the coefficients become those of eq. (14). Of second
    order. `series` is a row of `damped_motion`.
    """
    keep, one, two, three = series
    slope = (3.0 * force - 4.0 * last + before) / (2.0 * dt)
    return (
        place + dt * one * velocity + dt**2 * two * force + dt**3 * three * slope,
        keep * velocity + dt * one * force + dt**2 * two * slope,
    )


MAX_TRAVEL = 0.5
"""Largest distance that a particle moves in a step, in d_min: one that moves farther may cross an edge unnoticed."""

_UNDER_WAY_FRACTION = 0.3
"""Fraction of the speed that the field alone gives a particle above which it is under way."""

_MIN_SPEED_BETA = 0.1
"""Least damping with which that speed is estimated."""


def fast_speed(parameters: Parameters) -> float:
    """Return the speed beyond which the field alone must drive a particle [px / unit of time]."""
    limit = MAX_TRAVEL * parameters.d_min / parameters.time_step
    return _UNDER_WAY_FRACTION * min(parameters.w2 / max(parameters.beta, _MIN_SPEED_BETA), limit)


@compiled
def is_stuck(pull: float, speed: float, w1: float, idle: int) -> bool:
    """Return whether static friction holds a particle on an edge: speed and force `pull` along the edge are small.

    Like charges on a conductor, particles would creep without end from bays to tips. A contour only needs an
    equilibrium whose spacing differs by some ten percent from one neighbor to the next, and friction stops the
    particles there. Once they have stopped covering new cells, `idle` steps ago, it grows until all of them are at
    rest.
    """
    return pull < (_STICTION_FORCE + _STICTION_GROWTH * idle) * w1 and speed < _STUCK_SPEED


EPSILON_BOUND = 0.001
"""Bound of eq. (23) [px]."""

QUIET_STEPS = 20
"""Consecutive quiet steps of an equilibrium."""

IDLE_STEPS = 10
"""Steps without newly covered cells after which a coarser scale is finished."""

STILL_DISTANCE = 0.02
"""Motion in a step under which a particle does not count as moving [px]."""

_QUIET_FRACTION = 0.002
"""Fraction of the particles that may move, be inserted or be deleted in a quiet step."""

_PROGRESS_FRACTION = 0.003
"""Fraction of the coverage that a step must add to count as progress."""


def equilibrium_epsilon(distance: Array) -> float:
    """Return the left side of eq. (23), ``|sum_i (-1)^i sum_j |r_j(t_k-i)|| / N`` [px].

    `distance`, shape (N, T), is ``|r|`` of every particle at the last T steps, newest first. Rows with NaN do not
    count: their particles are too young. NaN if no particle is T steps old.
    """
    sums = distance @ (-1.0) ** np.arange(1, HISTORY_STEPS + 1)
    old = sums[~np.isnan(sums)]
    return abs(float(old.sum())) / len(old) if len(old) else float("nan")


def is_quiet(epsilon: float, moving: int, changed: int, count: int) -> bool:
    """Return whether few of `count` particles moved or changed in a step; `epsilon` is that of eq. (23) [px]."""
    few = _QUIET_FRACTION * count
    return epsilon < EPSILON_BOUND and moving <= few and changed <= few


def is_idle(new: int, coverage: int) -> bool:
    """Return whether a step newly covered next to no cells, compared with the covered cells so far."""
    return new <= _PROGRESS_FRACTION * coverage


DELETION_DISTANCE = 0.5
"""Least distance of two particles, in d_min."""

_PAPER = Parameters()
"""The values of the paper."""

_MIN_CREEPING_BETA = 0.01
"""Damping that counts where there is less."""


def _creeping_drive(parameters: Parameters) -> float:
    """Return what a front creeps by: push against hold, times steps before births end, times the way of coasting."""
    push = parameters.w1 / (parameters.w2 - parameters.w1)
    return push / (1.0 - parameters.annealing) / max(parameters.beta, _MIN_CREEPING_BETA) ** 2


def creeping_range(parameters: Parameters) -> float:
    """Return the distance that a front creeps along edges once it has left the area of its start [px].

    It is the parameter `reach` at the values of the paper. Repulsion drives a front against the hold of the edges,
    ``w1 / (w2 - w1)``, for as many steps as annealing leaves, ``1 / (1 - a)``, over stretches as long as a particle
    coasts against the damping, which grow with ``1 / beta^2``. An unlimited reach, that of
    every volume, sets no limit with as much drive as that of the paper; with less it counts as a reach of its length.
    """
    if parameters.annealing == 1.0:
        return float("inf") if parameters.reach * parameters.w1 > 0.0 else 0.0
    drive = _creeping_drive(parameters) / _creeping_drive(_PAPER)
    return float("inf") if parameters.reach >= UNLIMITED_REACH and drive >= 1.0 else parameters.reach * drive
