"""The laws of motion of a particle: total force of eq. (12) and one step of eq. (14)-(15), and equilibrium, eq. (23).

The laws are compiled functions of single numbers, for the loops that apply them to every particle, in any number of
dimensions.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.model.state import MEMORY, Particles
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters import Parameters

_SOFTNESS = 0.5
"""Slope of the normalized Coulomb force near equilibrium; with it the integrator keeps the stiffest mode of a chain of
particles, neighbors moving against each other, stable at the default time step."""

_STICTION, _STICTION_GROWTH = 0.25, 0.02
"""Largest force along an edge, as a fraction of w1, under which a particle on it stays at rest, and its growth for each
step without newly covered cells."""

_FADING = 0.04
"""Fraction of the repulsion that is lost for each step without newly covered cells."""

_COOLING, _LONGEST_COOLING, _LEAST_DAMPING = 12.0, 200.0, 0.1
"""Steps in which damping doubles once the repulsion has faded, those during which it continues to double, and its least
initial value."""

FADED = round(1.0 / _FADING)
"""Steps without newly covered cells after which no repulsion is left."""

LATEST = FADED + int(_LONGEST_COOLING)
"""Steps without newly covered cells after which the damping is constant."""

_STUCK_SPEED = 0.3
"""Largest speed along an edge at which static friction acts [px / unit of time]."""


@compiled
def coulomb_scale(size: float, spacing: float, d_min: float) -> float:
    """Factor that normalizes the Coulomb force: of unit size on a sparse front, falling to zero near equilibrium.

    The unit vector of the sum never comes to rest: its direction flips around equilibrium. Scaled by the squared local
    spacing the sum is a pure number, of order one on a particle with neighbors on one side only and small where they
    balance; only what exceeds one is cut. `size` is the length of the sum of eq. (9), `spacing` the mean distance to
    the two nearest particles [px]; below `d_min` [px] the force softens further.
    """
    scale = _SOFTNESS * spacing**2 * min(1.0, spacing / d_min)
    scale /= max(1.0, size * scale)
    return scale


@compiled
def repulsion_left(idle: int) -> float:
    """Fraction of the Coulomb force on a particle, from 1 to 0, `idle` steps after cells around it were newly covered.

    As long as coverage grows the repulsion is not reduced. Afterwards it could only make particles creep, on edges from
    bays to tips and off edges against those on them, so it fades, and all particles reach an edge and come to rest.
    """
    return max(0.0, 1.0 - _FADING * idle)


@compiled
def damping(beta: float, idle: int) -> float:
    """Damping coefficient of a particle, `idle` steps after cells around it were newly covered: beta, later more.

    A particle that still moves without repulsion follows the field where there is no edge. The growing damping brings
    it to rest.
    """
    late = min(max(idle - float(FADED), 0.0), _LONGEST_COOLING)
    return max(beta, _LEAST_DAMPING) * 2.0 ** (late / _COOLING) if late > 0.0 else beta


@compiled
def damped_series(z: float) -> tuple[float, float, float, float]:
    """``exp(-z)`` and the weights that damping ``z = beta dt`` leaves of 1, 1/2 and 1/6 in eq. (14)."""
    keep = np.exp(-z)
    if z < 1e-2:  # the closed forms cancel for small z; the series are exact to rounding there
        one = 1.0 - z / 2.0 + z**2 / 6.0 - z**3 / 24.0 + z**4 / 120.0
        two = 0.5 - z / 6.0 + z**2 / 24.0 - z**3 / 120.0 + z**4 / 720.0
        three = 1.0 / 6.0 - z / 24.0 + z**2 / 120.0 - z**3 / 720.0 + z**4 / 5040.0
        return keep, one, two, three
    one = -np.expm1(-z) / z
    two = (1.0 - one) / z
    return keep, one, two, (0.5 - two) / z


@compiled
def advance(
    place: float,
    velocity: float,
    force: float,
    last: float,
    before: float,
    dt: float,
    series: tuple[float, float, float, float],
) -> tuple[float, float]:
    """Position and velocity of one coordinate of a particle after a time step, eq. (14)-(15).

    The undamped force is continued by its Taylor series, whose derivative is eq. (15): the quadratic through the last
    three forces ``w1 F_c + w2 F_l``, now and at the two steps before. Damping is linear and therefore integrated
    exactly, which keeps every beta stable; as beta goes to zero the coefficients become those of eq. (14). Of second
    order. `series` is `damped_series` of ``beta dt``.
    """
    keep, one, two, three = series
    slope = (3.0 * force - 4.0 * last + before) / (2.0 * dt)
    return (
        place + dt * one * velocity + dt**2 * two * force + dt**3 * three * slope,
        keep * velocity + dt * one * force + dt**2 * two * slope,
    )


_UNDER_WAY, _LEAST_BETA = 0.3, 0.1
"""Fraction of the speed that the field alone gives a particle above which it is under way, and the least damping with
which that speed is estimated."""


def fast_speed(parameters: Parameters) -> float:
    """Speed above which the field alone must drive a particle [px / unit of time]."""
    return _UNDER_WAY * (parameters.w2 / max(parameters.beta, _LEAST_BETA))


@compiled
def is_stuck(pull: float, speed: float, w1: float, idle: int) -> bool:
    """Whether static friction holds a particle on an edge: its speed and the force `pull` along the edge are small.

    Like charges on a conductor, particles would creep without end from bays to tips. A contour only needs an
    equilibrium whose spacing differs by some ten percent from one neighbor to the next, and friction stops the
    particles there. Once they have stopped covering new cells, `idle` steps ago, it grows until all of them are at
    rest.
    """
    return pull < (_STICTION + _STICTION_GROWTH * idle) * w1 and speed < _STUCK_SPEED


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


NEAR = 0.5
"""Least distance of two particles, in d_min."""


STRIDE, STRIDE_ROOM = 0.9, 0.8
"""Distance, in d_min, of a position ahead of a particle, and its distance from all others."""


class Moved(NamedTuple):
    """Particles after a step, and the distance that each of them has moved [px], shape (N,)."""

    particles: Particles
    motion: Array

    @classmethod
    def unset(cls, particles: Particles) -> Moved:
        """Arrays for the result of a step; the identities are those of the particles."""
        after = Particles(
            np.empty_like(particles.position),
            np.empty_like(particles.velocity),
            np.empty_like(particles.force),
            np.empty_like(particles.distance),
            particles.identity,
        )
        return cls(after, np.empty(len(particles)))

    def of(self, index: Index) -> Moved:
        """Those of the particles with the given indices, in this order."""
        return Moved(self.particles.renewed(index), self.motion[index])

    @classmethod
    def held_at(cls, particles: Particles, start: Array) -> Moved:
        """Particles that barriers held back on their way from `start`, shape (N, D)."""
        particles.distance[:, 0] = np.linalg.norm(particles.position, axis=1)
        return cls(particles, np.linalg.norm(particles.position - start, axis=1))
