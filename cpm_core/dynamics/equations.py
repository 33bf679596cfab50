"""The laws of motion of a particle: total force of eq. (12) and one step of eq. (14)-(15).

All of them are compiled, of single numbers, for the loop in `integrator` that applies them to every particle, in any
number of dimensions.
"""

from __future__ import annotations

import numpy as np

from cpm_core.numerics.jit import compiled

_SOFTNESS = 0.5
"""Slope of the normalized Coulomb force near equilibrium; with it the stiffest mode of a chain of particles, neighbors
moving against each other, stays within what the integrator keeps stable at the default time step."""

_STICTION, _STICTION_GROWTH = 0.25, 0.02
"""Force along an edge, as a fraction of w1, that a particle at rest on it withstands, and how much more of it for each
step since cells were last newly covered."""

_FADING = 0.04
"""Fraction of the repulsion that goes with each step since cells were last newly covered."""

_COOLING, _LONGEST_COOLING, _LEAST_DAMPING = 12.0, 200.0, 0.1
"""Steps after which damping has doubled once the repulsion is gone, those for which it goes on doubling, and what it
starts from at least."""

FADED = round(1.0 / _FADING)
"""Steps without news after which the repulsion is gone."""

LATEST = FADED + int(_LONGEST_COOLING)
"""Steps without news from which on the damping is the same."""

_STUCK_SPEED = 0.3
"""Speed along an edge under which a particle counts as at rest for that [px / unit of time]."""


@compiled
def coulomb_scale(size: float, spacing: float, d_min: float) -> float:
    """Factor that normalizes the Coulomb force: of unit size on a sparse front, falling to zero near equilibrium.

    The unit vector of the sum never rests: its direction flips around equilibrium. Scaled by the squared local spacing
    the sum is a pure number, of order one on a particle with neighbors on one side only and small where they balance;
    only what exceeds one is cut.

    Parameters
    ----------
    size : float
        Length of the sum of eq. (9).
    spacing : float
        Mean distance to the two nearest particles [px].
    d_min : float
        Spacing [px] below which the force softens further.

    Returns
    -------
    float
        What the sum is multiplied by, for a force of at most unit size.
    """
    scale = _SOFTNESS * spacing**2 * min(1.0, spacing / d_min)
    scale /= max(1.0, size * scale)
    return scale


@compiled
def repulsion_left(idle: int) -> float:
    """Fraction of the Coulomb force that acts on a particle with no newly covered cells around it for long.

    As long as coverage grows the repulsion is whole. Afterwards it can only keep particles creeping, on edges
    from bays to tips and in flight against those that already sit, and it is let fade, so that everything lands and
    rests.

    Parameters
    ----------
    idle : int
        Steps since cells around it were newly covered.

    Returns
    -------
    float
        From 1 down to 0.
    """
    return max(0.0, 1.0 - _FADING * idle)


@compiled
def damping(beta: float, idle: int) -> float:
    """Damping coefficient of a particle: beta, and more where nothing new has been found for long.

    Once the repulsion is gone what still moves follows the field along some valley where there is nothing to find. The
    growing damping brings it to rest.

    Parameters
    ----------
    beta : float
        Damping coefficient of eq. (12).
    idle : int
        Steps since cells around it were newly covered.

    Returns
    -------
    float
        Coefficient.
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
    """Advance one coordinate of a particle by one time step, eq. (14)-(15).

    The undamped force is carried on by its Taylor series, whose derivative is eq. (15): the quadratic through the last
    three forces. Damping is linear and therefore integrated exactly, which keeps every beta stable; as beta goes to
    zero the coefficients become those of eq. (14). Of second order.

    Parameters
    ----------
    place, velocity : float
        Before the step [px, px / unit of time].
    force, last, before : float
        ``w1 F_c + w2 F_l`` now and at the two steps before.
    dt : float
        Time step.
    series : tuple of float
        `damped_series` of ``beta dt``.

    Returns
    -------
    float, float
        Place and velocity after the step.
    """
    keep, one, two, three = series
    slope = (3.0 * force - 4.0 * last + before) / (2.0 * dt)
    return (
        place + dt * one * velocity + dt**2 * two * force + dt**3 * three * slope,
        keep * velocity + dt * one * force + dt**2 * two * slope,
    )


@compiled
def is_stuck(pull: float, speed: float, w1: float, idle: int) -> bool:
    """Whether static friction holds a particle that sits on an edge: if it is slow and the force along the edge small.

    Like charges on a conductor the particles would go on creeping for ever from bays to tips; an equilibrium that keeps
    the spacing within some ten percent from one neighbor to the next is all that a contour needs, and this makes it
    one. Once the particles have stopped covering new cells, friction grows until all of them rest.

    Parameters
    ----------
    pull : float
        Size of the force along the edge.
    speed : float
        Speed along the edge [px / unit of time].
    w1 : float
        Coulomb weight, the measure of the force.
    idle : int
        Steps since cells around it were newly covered.
    """
    return pull < (_STICTION + _STICTION_GROWTH * idle) * w1 and speed < _STUCK_SPEED
