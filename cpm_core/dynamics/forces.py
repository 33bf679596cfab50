"""The forces of eq. (12) on particles, each by itself: what a step adds up without keeping it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.dynamics.equations import FADED, LATEST, damping
from cpm_core.dynamics.integrator import far_force_of, is_asleep, undamped_force
from cpm_core.field.plane import interpolate_felt
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.types import Array, Index
from cpm_core.parameters import Parameters
from cpm_core.particles.state import State

_NO_EDGES = np.zeros((2, 2, 5), np.float32)
_NO_EDGES[..., 0] = 1.0
"""What is felt where there is no edge, hence no friction, and the Lorentz force is one downwards."""


@dataclass(frozen=True, eq=False, slots=True)
class Forces:
    """Forces on particles in eq. (12), with their weights; all of shape (N, 2) [px of the scale / unit of time^2].

    Attributes
    ----------
    coulomb : ndarray
        ``w1 F_c``, as far as the repulsion has not faded.
    lorentz : ndarray
        ``w2 F_l``, of the image alone.
    placed : ndarray
        ``w2`` times the force of the placed charges.
    friction : ndarray
        What holds a particle that is slow, or asleep, on its edge: it cancels what the others have along the edge.
    damping : ndarray
        ``-beta v``, with the greater beta of particles that are made to rest; none of those that are asleep.
    """

    coulomb: Array
    lorentz: Array
    placed: Array
    friction: Array
    damping: Array

    @property
    def total(self) -> Array:
        """Sum of them all: the acceleration with which the next step begins."""
        return self.coulomb + self.lorentz + self.placed + self.friction + self.damping


def forces(
    state: State, scale_field: ScaleField, charged: ScaleField, idle: Index, parameters: Parameters, index: ArrayLike
) -> Forces:
    """Forces on some particles; see `Engine.forces`.

    Parameters
    ----------
    state : State
        As the next step takes it up.
    scale_field, charged : ScaleField
        What is felt at its scale, without the placed charges and with them.
    idle : ndarray of int64, shape (N,)
        Steps since there was new ground around each particle.
    parameters : Parameters
        Of the next step.
    index : array_like of int, shape (M,)
        Which particles.
    """
    particles, which = state.particles, np.atleast_1d(np.asarray(index, dtype=np.int64))
    chosen = particles.taken(which)
    far = far_force_of(state, idle, scale_field, parameters)
    lorentz = parameters.w2 * interpolate_felt(scale_field.packed, chosen.position)
    placed = parameters.w2 * interpolate_felt(charged.packed, chosen.position) - lorentz
    coulomb = np.zeros_like(lorentz)
    feeling = np.flatnonzero(idle[which] < FADED)
    if len(feeling):
        coulomb[feeling] = undamped_force(
            particles, which[feeling], idle, far, _NO_EDGES, scale_field.shape, parameters
        )
        coulomb[feeling, 0] -= parameters.w2
    applied = undamped_force(particles, which, idle, far, charged.packed, scale_field.shape, parameters)
    late, kinds = np.unique(np.minimum(idle[which], LATEST), return_inverse=True)
    beta = np.array([damping(parameters.beta, int(steps)) for steps in late])[kinds]
    damped = -beta[:, None] * chosen.velocity
    asleep = is_asleep(chosen, idle[which])
    applied[asleep], damped[asleep] = 0.0, 0.0
    return Forces(coulomb, lorentz, placed, applied - (coulomb + lorentz + placed), damped)
