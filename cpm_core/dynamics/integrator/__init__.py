"""The motion of all particles in one time step: the laws of `equations`, applied to each in one compiled loop.

A step skips a particle that is at rest where no cell has been newly covered for long: nothing that could move it
changes, until cells near it are newly covered or an intervention reactivates the run.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from cpm_core.dynamics.equations import FADED, LATEST, damped_series, damping
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.particles.state import Particles

REACH = 2.0
"""Reach of the pairs where a mesh carries the rest, in d_min + d_max."""

NEIGHBOR_RANGE = 8.0
"""Largest distance at which the two nearest neighbors are searched, in d_min + d_max."""

REST_SPEED = 5e-4
"""Speed under which a particle is at rest where no cell has been newly covered for long [px / unit of time]."""


@dataclass(frozen=True, eq=False, slots=True)
class Moved:
    """Particles after a step.

    Attributes
    ----------
    particles : Particles
        All of them.
    motion : ndarray, shape (N,)
        Distance that each has moved [px].
    strength : ndarray, shape (N,)
        Edge strength at each.
    on_edge : ndarray of bool, shape (N,)
        Which of them are on an edge.
    """

    particles: Particles
    motion: Array
    strength: Array
    on_edge: Mask

    @classmethod
    def unset(cls, particles: Particles) -> Moved:
        """Arrays for the result of a step; the identities are those of the particles."""
        count = len(particles)
        after = Particles(
            np.empty_like(particles.position),
            np.empty_like(particles.velocity),
            np.empty_like(particles.force),
            np.empty_like(particles.distance),
            particles.identity,
        )
        return cls(after, np.empty(count), np.empty(count), np.empty(count, np.bool_))

    def where(self, kept: Mask) -> Moved:
        """The particles for which `kept`, shape (N,), is true."""
        return Moved(self.particles.where(kept), self.motion[kept], self.strength[kept], self.on_edge[kept])

    @classmethod
    def held_at(cls, particles: Particles, start: Array, contact: tuple[Array, Mask]) -> Moved:
        """Particles that barriers held back on their way from `start`, shape (N, D), with their edge contact."""
        particles.distance[:, 0] = np.linalg.norm(particles.position, axis=1)
        return cls(particles, np.linalg.norm(particles.position - start, axis=1), *contact)


class Law(NamedTuple):
    """The parameters of motion: weights of eq. (12), spacing, time step, and `NEIGHBOR_RANGE` in px."""

    w1: float
    w2: float
    d_min: float
    dt: float
    neighbor_range: float


@lru_cache(maxsize=8)
def damped_motion(beta: float, dt: float) -> Array:
    """Series of the damped motion by the steps without newly covered cells; the last row is for all later ones.

    This is the damping ``-beta v`` of eq. (12), integrated in closed form; ``beta = 0`` gives eq. (14).
    """
    return np.array([damped_series(damping(beta, idle) * dt) for idle in range(LATEST + 1)])


def is_at_rest(particles: Particles, idle: Index) -> Mask:
    """Which particles the next step skips, shape (N,)."""
    slow = np.einsum("ni,ni->n", particles.velocity, particles.velocity) < REST_SPEED**2
    return np.asarray(slow & (idle >= FADED) & ~particles.young)
