"""Kinetic and potential energy of the particles in the plane; see `cpm_core.dynamics.energies`."""

from __future__ import annotations

from cpm_core.dynamics.energies import PAIR, Energies, kinetic_energy
from cpm_core.field.interpolation import interpolate
from cpm_core.field.placed_charges import placed_potential, radius_at
from cpm_core.field.scale_field import ScaleField
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list.plane import build_cells
from cpm_core.particles.coulomb.pair_force.plane import pair_energy
from cpm_core.particles.state import State


def energies(state: State, scale_field: ScaleField, parameters: Parameters) -> Energies:
    """Energies of a state with its placed charges; `scale_field` is without them. See `Engine.energies`."""
    particles = state.particles
    in_image = 4.0**state.scale
    reach = parameters.d_min + parameters.d_max
    pairs = pair_energy(build_cells(particles.position, scale_field.shape, reach), reach)
    fixed = interpolate(scale_field.potential[None], particles.position).sum() / scale_field.slope
    placed = placed_potential(state.placed, radius_at(state.scale), particles.position).sum()
    mutual = PAIR * parameters.w1 * parameters.d_min**2 * pairs
    return Energies(kinetic_energy(state), in_image * (mutual + parameters.w2 * float(fixed + placed)))
