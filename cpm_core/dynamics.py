"""The motion of the particles: total force of eq. (12) and one step of eq. (14)-(15)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cpm_core.particles import Particles

Array = NDArray[np.float64]

_SOFTNESS = 0.5
"""Slope of the normalised Coulomb force near equilibrium; with it the stiffest mode of a chain of particles, neighbours
moving against each other, stays within what the integrator keeps stable at the default time step."""

_STICTION, _STICTION_GROWTH = 0.25, 0.02
"""Force along an edge, as a fraction of w1, that a particle at rest on it withstands, and how much more of it for each
step since particles last reached new ground."""

_FADING = 0.02
"""Fraction of the repulsion that goes with each step since particles last reached new ground."""

_COOLING, _LONGEST_COOLING, _LEAST_DAMPING = 20.0, 200.0, 0.1
"""Steps after which damping has doubled once the repulsion is gone, those for which it goes on doubling, and what it
starts from at least."""

_STUCK_SPEED = 0.3
"""Speed along an edge under which a particle counts as at rest for that [px / unit of time]."""


def normalised_coulomb(force: Array, spacing: Array, d_min: float) -> Array:
    """Coulomb force of unit size on a sparse front, falling linearly to zero near equilibrium.

    The unit vector of the sum never rests: its direction flips around equilibrium. Scaled by the squared local spacing
    the sum is a pure number, of order one on a particle with neighbours on one side only and small where they balance;
    only what exceeds one is cut.

    Parameters
    ----------
    force : ndarray, shape (N, D)
        Sums of eq. (9).
    spacing : ndarray, shape (N,)
        Mean distance to the two nearest particles [px].
    d_min : float
        Spacing [px] below which the force softens further.

    Returns
    -------
    ndarray, shape (N, D)
        Force of at most unit size.
    """
    scale = _SOFTNESS * spacing**2 * np.minimum(1.0, spacing / d_min)
    size = np.linalg.norm(force, axis=1) * scale
    return np.asarray(force * (scale / np.maximum(1.0, size))[:, None])


def repulsion_left(idle: NDArray[np.int64]) -> Array:
    """Fraction of the Coulomb force that acts on particles whose neighbourhood has stopped gaining ground.

    As long as there is ground to gain the repulsion is whole. Afterwards it can only keep particles creeping, on edges
    from bays to tips and in flight against those that already sit, and it is let fade, so that everything lands and
    rests.

    Parameters
    ----------
    idle : ndarray of int64, shape (N,)
        Steps since there was new ground around each.

    Returns
    -------
    ndarray, shape (N,)
        From 1 down to 0.
    """
    return np.asarray(np.maximum(0.0, 1.0 - _FADING * idle))


def damping(beta: float, idle: NDArray[np.int64]) -> Array:
    """Damping coefficient of each particle: beta, and more where nothing new has been found for long.

    Once the repulsion is gone what still moves follows the field along some valley where there is nothing to find. The
    growing damping brings it to rest.

    Parameters
    ----------
    beta : float
        Damping coefficient of eq. (12).
    idle : ndarray of int64, shape (N,)
        Steps since there was new ground around each particle.

    Returns
    -------
    ndarray, shape (N,)
        Coefficients.
    """
    late = np.clip(idle - 1.0 / _FADING, 0.0, _LONGEST_COOLING)
    return np.asarray(np.where(late > 0.0, max(beta, _LEAST_DAMPING) * np.exp2(late / _COOLING), beta))


def advance(particles: Particles, force: Array, beta: Array, dt: float) -> Particles:
    """Advance the particles by one time step, eq. (14)-(15).

    The undamped force is carried on by its Taylor series, whose derivative is eq. (15): the quadratic through the last
    three forces. Damping is linear and therefore integrated exactly, which keeps every beta stable; as beta goes to
    zero the coefficients become those of eq. (14). Of second order.

    Parameters
    ----------
    particles : Particles
        Before the step.
    force : ndarray, shape (N, D)
        ``w1 F_c + w2 F_l`` on them.
    beta : ndarray, shape (N,)
        Damping coefficient of each.
    dt : float
        Time step.

    Returns
    -------
    Particles
        After the step.
    """
    last, before = particles.force
    slope = (3.0 * force - 4.0 * last + before) / (2.0 * dt)
    keep, one, two, three = _damped_series(beta[:, None] * dt)
    velocity = particles.velocity
    return replace(
        particles,
        position=particles.position + dt * one * velocity + dt**2 * two * force + dt**3 * three * slope,
        velocity=keep * velocity + dt * one * force + dt**2 * two * slope,
        force=np.stack([force, last]),
    )


def _damped_series(z: Array) -> tuple[Array, Array, Array, Array]:
    """``exp(-z)`` and the weights that damping ``z = beta dt`` leaves of 1, 1/2 and 1/6 in eq. (14)."""
    # The closed forms cancel for small z; the series are exact to rounding there.
    small = z < 1e-2
    safe = np.where(small, 1.0, z)
    keep = np.exp(-z)
    one = np.where(small, 1.0 - z / 2.0 + z**2 / 6.0 - z**3 / 24.0 + z**4 / 120.0, -np.expm1(-safe) / safe)
    two = np.where(small, 0.5 - z / 6.0 + z**2 / 24.0 - z**3 / 120.0 + z**4 / 720.0, (1.0 - one) / safe)
    three = np.where(small, 1.0 / 6.0 - z / 24.0 + z**2 / 120.0 - z**3 / 720.0 + z**4 / 5040.0, (0.5 - two) / safe)
    return keep, one, two, three


def stick(
    particles: Particles, force: Array, normal: Array, seated: NDArray[np.bool_], w1: float, idle: NDArray[np.int64]
) -> tuple[Particles, Array]:
    """Static friction: a slow particle on an edge does not yield to a small force along it.

    Like charges on a conductor the particles would go on creeping for ever from bays to tips; an equilibrium that keeps
    the spacing within some ten percent from one neighbour to the next is all that a contour needs, and this makes it
    one. Once the particles have stopped finding new ground, friction grows until all of them rest.

    Parameters
    ----------
    particles : Particles
        Before the step.
    force : ndarray, shape (N, D)
        ``w1 F_c + w2 F_l`` on them.
    normal : ndarray, shape (N, D)
        Image gradient at each, normal to the edge; of any length.
    seated : ndarray of bool, shape (N,)
        Which sit on an edge.
    w1 : float
        Coulomb weight, the measure of the force.
    idle : ndarray of int64, shape (N,)
        Steps since there was new ground around each.

    Returns
    -------
    particles : Particles
        The stuck ones without velocity and force history along the edge.
    force : ndarray, shape (N, D)
        The force without what friction takes.
    """
    unit = normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]

    def across(vectors: Array) -> Array:
        return np.asarray(np.einsum("...i,...i->...", vectors, unit)[..., None] * unit)

    pull = np.linalg.norm(force - across(force), axis=1)
    speed = np.linalg.norm(particles.velocity - across(particles.velocity), axis=1)
    stuck = (seated & (pull < (_STICTION + _STICTION_GROWTH * idle) * w1) & (speed < _STUCK_SPEED))[:, None]
    held = replace(
        particles,
        velocity=np.where(stuck, across(particles.velocity), particles.velocity),
        force=np.where(stuck, across(particles.force), particles.force),
    )
    return held, np.asarray(np.where(stuck, across(force), force))
