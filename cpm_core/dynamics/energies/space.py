"""Kinetic and potential energy of the particles in a volume; see `cpm_core.dynamics.energies`."""

from __future__ import annotations

from cpm_core.dynamics.edge_contact.space import on_one_sheet
from cpm_core.dynamics.energies import PAIR, Energies, kinetic_energy
from cpm_core.dynamics.integrator.space import REACH
from cpm_core.dynamics.time_step.space import cells_of
from cpm_core.field.interpolation import interpolate
from cpm_core.field.placed_charges import radius_at
from cpm_core.field.volume.placed_charges import placed_potential
from cpm_core.field.volume.volume_field import VolumeField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask
from cpm_core.numerics.vectors import difference, dot, row_of
from cpm_core.parameters import Parameters
from cpm_core.particles.cell_list.space import Cells, cells_around, row_of_cells
from cpm_core.particles.state import State

_NEAREST = 1e-4
"""Least squared distance of two particles in their energy [units^2], as in their force."""


def energies(state: State, field: VolumeField, parameters: Parameters) -> Energies:
    """Energies of a state with its placed charges; `field` is without them. See `Engine.energies`."""
    particles, contact = state.particles, state.particles.contact
    assert contact is not None
    position, reach = particles.position, REACH * parameters.d_min
    cells = cells_of(particles, field, parameters.d_min)
    pairs = _pair_energy(cells, position, contact.normal, contact.seated, reach)
    fixed = interpolate(field.potential[None], position / field.pitch).sum() / field.slope
    placed = placed_potential(state.placed, radius_at(state.scale), position).sum()
    mutual = PAIR * parameters.w1 * parameters.d_min**3 * pairs
    in_volume = 4.0**state.scale
    return Energies(kinetic_energy(state), in_volume * (mutual + parameters.w2 * float(fixed + placed)))


@compiled
def _pair_energy(cells: Cells, position: Array, normals: Array, seated: Mask, reach: float) -> float:
    """Sum of ``(1/r^2 - 1/R^2) / 2`` over the pairs nearer than the reach R, but for those on different sheets."""
    total = 0.0
    for i in range(len(position)):
        place = row_of(position, i)
        top, bottom, front, back, left, right = cells_around(cells, place[0], place[1], place[2], reach)
        for plane in range(top, bottom + 1):
            for row in range(front, back + 1):
                start, end = row_of_cells(cells, plane, row, left, right)
                for k in range(start, end):
                    away = difference(place, (cells.z[k], cells.y[k], cells.x[k]))
                    squared, j = dot(away, away), cells.order[k]
                    if j < i and squared < reach * reach and on_one_sheet(i, j, normals, seated):
                        total += 0.5 * (1.0 / max(squared, _NEAREST) - 1.0 / (reach * reach))
    return total
