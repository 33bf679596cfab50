"""Kinetic and potential energy of the particles: what the damping takes out of a run until it is at rest.

The forces of the model are normalised and have no potential of their own. Its energy is reckoned by the potentials that
they come from, in their measure:

- The Lorentz force has unit size away from edges, however steep the potential of the fixed charges is there: it counts
  in units of its mean slope, so that it pulls with w2 on average. That of placed charges is exact, but for the cut of
  their sum.
- The Coulomb force of two particles ``d_min`` apart is half of w1: a pair counts as ``0.5 w1 d_min^2 (1/r - 1/R)``, up
  to the distance ``R = d_min + d_max`` to which particles have neighbours. Farther ones make little difference, since
  the force on a particle is scaled by the distance to its neighbours.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cpm_core.field.interpolation import interpolate
from cpm_core.field.placed_charges import at_scale, placed_potential, radius_at
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.jit import compiled
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list import Cells, build_cells, cells_around, row_of_cells
from cpm_core.particles.state import State

_PAIR = 0.5
"""Coulomb force of two particles d_min apart, in w1."""

_NEAREST = 0.1
"""Distance as which a smaller one of two particles counts [px]: their energy stays finite."""


@dataclass(frozen=True, slots=True)
class Energies:
    """Energies of all particles together, of unit mass each [px^2 of the image / unit of time^2].

    Attributes
    ----------
    kinetic : float
        Sum of ``v^2 / 2``.
    potential : float
        In the field of the fixed charges and of the placed ones, and of near pairs of particles.
    """

    kinetic: float
    potential: float


def energies(state: State, scale_field: ScaleField, parameters: Parameters) -> Energies:
    """Energies of the particles of a state; see `Engine.energies`.

    Parameters
    ----------
    state : State
        With the placed charges that count.
    scale_field : ScaleField
        What is felt at its scale, without placed charges.
    parameters : Parameters
        For the weights, `d_min` and `d_max`.
    """
    particles = state.particles
    in_image = 4.0**state.scale
    height, width = scale_field.shape
    reach = parameters.d_min + parameters.d_max
    pairs = _near_pairs(build_cells(particles.position, height, width, reach), reach)
    fixed = interpolate(scale_field.potential[None], particles.position).sum() / scale_field.slope
    charges = at_scale(state.charges, state.scale, state.shape)
    placed = placed_potential(charges, radius_at(state.scale), particles.position).sum()
    mutual = _PAIR * parameters.w1 * parameters.d_min**2 * pairs
    return Energies(kinetic_energy(state), in_image * (mutual + parameters.w2 * float(fixed + placed)))


def kinetic_energy(state: State) -> float:
    """Kinetic energy of the particles of a state [px^2 of the image / unit of time^2]; next to no work."""
    velocity = state.particles.velocity
    return 0.5 * 4.0**state.scale * float(np.einsum("ni,ni->", velocity, velocity))


@compiled
def _near_pairs(cells: Cells, reach: float) -> float:
    """Sum of ``1/r - 1/R`` over the pairs nearer than R."""
    total = 0.0
    for k in range(len(cells.y)):
        y, x = cells.y[k], cells.x[k]
        top, bottom, left, right = cells_around(cells, y, x, reach)
        for row in range(top, bottom + 1):
            first, last = row_of_cells(cells, row, left, right)
            for j in range(max(first, k + 1), last):
                squared = (cells.y[j] - y) ** 2 + (cells.x[j] - x) ** 2
                if squared < reach**2:
                    total += 1.0 / max(np.sqrt(squared), _NEAREST) - 1.0 / reach
    return total
