"""Edge contact on an image of rows and columns."""

from __future__ import annotations

import numpy as np

from cpm_core.dynamics.edge_contact import is_on_edge
from cpm_core.field.interpolation.plane import between, component
from cpm_core.field.scale_field import ScaleField
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask, Single


def contact_at(positions: Array, scale_field: ScaleField) -> tuple[Array, Mask]:
    """Edge strength at particles, shape (N, 2), and which of them are on an edge."""
    strength, on_edge = np.empty(len(positions)), np.empty(len(positions), np.bool_)
    _contact_at(scale_field.packed, scale_field.floor, positions, strength, on_edge)
    return strength, on_edge


@compiled
def _contact_at(packed: Single, floor: float, position: Array, strength: Array, on_edge: Mask) -> None:
    for i in range(len(position)):
        strength[i], on_edge[i] = on_edge_at(packed, position[i, 0], position[i, 1], floor)


@compiled
def on_edge_at(packed: Single, y: float, x: float, floor: float) -> tuple[float, bool]:
    """Edge strength at a position, and whether a particle there is on an edge."""
    place = between(packed, y, x)
    f_y, f_x, strength = component(packed, 0, place), component(packed, 1, place), component(packed, 4, place)
    return strength, is_on_edge(f_y**2 + f_x**2, strength, floor)
