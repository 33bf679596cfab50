"""The forces of eq. (12) on particles in a volume."""

from __future__ import annotations

import numpy as np

from cpm_core.dynamics.equations import damping
from cpm_core.dynamics.forces import Forces
from cpm_core.dynamics.integrator.space import parts_of_force
from cpm_core.dynamics.time_step.space import cells_of, rested
from cpm_core.field.placed_charges import radius_at
from cpm_core.field.volume.placed_charges import Placed
from cpm_core.field.volume.volume_field import VolumeField
from cpm_core.numerics.types import Index
from cpm_core.parameters import Parameters
from cpm_core.particles.state import State


def forces(state: State, field: VolumeField, parameters: Parameters, which: Index) -> Forces:
    """Forces on the particles `which`, shape (M,), of a state as the next step begins; see `Engine.forces`."""
    charges = Placed(state.placed, radius_at(state.scale))
    idle, awake = rested(state.particles, state.step_of_scale)
    coulomb, lorentz, placed, friction = parts_of_force(
        state.particles, which, cells_of(state.particles, field, parameters.d_min), idle, field, parameters, charges
    )
    beta = np.array([damping(parameters.beta, int(steps)) for steps in idle[which]])
    damped = -beta[:, None] * state.particles.velocity[which]
    asleep = ~awake[which]
    friction[asleep] = -(coulomb + lorentz + placed)[asleep]
    damped[asleep] = 0.0
    return Forces(coulomb, lorentz, placed, friction, damped)
