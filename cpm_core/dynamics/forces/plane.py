"""The forces of eq. (12) on particles in the plane."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from cpm_core.dynamics.equations import FADED, LATEST, damping
from cpm_core.dynamics.forces import Forces
from cpm_core.dynamics.integrator import is_at_rest
from cpm_core.dynamics.integrator.plane import mesh_force_of, undamped_force
from cpm_core.field.interpolation.plane import interpolate_force
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.types import Index
from cpm_core.parameters import Parameters
from cpm_core.particles.state import State

_NO_EDGES = np.zeros((2, 2, 5), np.float32)
_NO_EDGES[..., 0] = 1.0
"""Packed force field without edges, hence without friction; its Lorentz force is one, downwards."""


def forces(
    state: State, scale_field: ScaleField, charged: ScaleField, idle: Index, parameters: Parameters, index: ArrayLike
) -> Forces:
    """Forces on the particles `index`, shape (M,), of a state as the next step begins; see `Engine.forces`.

    `scale_field` and `charged` are the fields of its scale without and with the placed charges, `idle`, shape (N,), the
    steps since cells around each particle were newly covered.
    """
    particles, which = state.particles, np.atleast_1d(np.asarray(index, dtype=np.int64))
    chosen = particles.taken(which)
    mesh = mesh_force_of(state, idle, scale_field, parameters)
    lorentz = parameters.w2 * interpolate_force(scale_field.packed, chosen.position)
    placed = parameters.w2 * interpolate_force(charged.packed, chosen.position) - lorentz
    coulomb = np.zeros_like(lorentz)
    repelled = np.flatnonzero(idle[which] < FADED)
    if len(repelled):
        coulomb[repelled] = undamped_force(
            particles, which[repelled], idle, mesh, _NO_EDGES, scale_field.shape, parameters
        )
        coulomb[repelled, 0] -= parameters.w2
    applied = undamped_force(particles, which, idle, mesh, charged.packed, scale_field.shape, parameters)
    late, kinds = np.unique(np.minimum(idle[which], LATEST), return_inverse=True)
    beta = np.array([damping(parameters.beta, int(steps)) for steps in late])[kinds]
    damped = -beta[:, None] * chosen.velocity
    at_rest = is_at_rest(chosen, idle[which])
    applied[at_rest], damped[at_rest] = 0.0, 0.0
    return Forces(coulomb, lorentz, placed, applied - (coulomb + lorentz + placed), damped)
