"""How the particles of a step stand: on an edge or not, and who is near whom."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cpm_core.field.plane import between, component
from cpm_core.field.scale_field import GATE, ScaleField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask, Single
from cpm_core.particles.cell_list import Cells


@dataclass(frozen=True, eq=False, slots=True)
class EdgeContact:
    """How the particles of a step stand.

    Attributes
    ----------
    strength : ndarray, shape (N,)
        Edge strength at each.
    on_edge : ndarray of bool, shape (N,)
        Which sit on an edge: where the interpolated unit field has fallen below the gate and the edge is strong enough.
    cells : Cells
        The particles sorted into cells, for neighbours up to a distance.
    """

    strength: Array
    on_edge: Mask
    cells: Cells


def contact_at(positions: Array, scale_field: ScaleField) -> tuple[Array, Mask]:
    """Edge strength at particles, shape (N, 2), and which of them sit on an edge."""
    strength, on_edge = np.empty(len(positions)), np.empty(len(positions), np.bool_)
    _seats(scale_field.packed, scale_field.floor, positions, strength, on_edge)
    return strength, on_edge


@compiled
def _seats(packed: Single, floor: float, position: Array, strength: Array, on_edge: Mask) -> None:
    for i in range(len(position)):
        strength[i], on_edge[i] = on_edge_at(packed, position[i, 0], position[i, 1], floor)


@compiled
def on_edge_at(packed: Single, y: float, x: float, floor: float) -> tuple[float, bool]:
    """Edge strength at a place, and whether a particle sits on an edge there.

    It does where the interpolated unit field has fallen below the gate and the edge is strong enough.
    """
    place = between(packed, y, x)
    f_y, f_x, strength = component(packed, 0, place), component(packed, 1, place), component(packed, 4, place)
    return strength, f_y**2 + f_x**2 < GATE**2 and strength >= floor
