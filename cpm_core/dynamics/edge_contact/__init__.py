"""Edge contact of the particles of a step: which of them are on an edge, and how strong it is there."""

from __future__ import annotations

from dataclasses import dataclass

from cpm_core.field.scale_field import GATE
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask
from cpm_core.particles.cell_list.plane import Cells


@dataclass(frozen=True, eq=False, slots=True)
class EdgeContact:
    """Edge contact and neighbors of the particles of a step.

    Attributes
    ----------
    strength : ndarray, shape (N,)
        Edge strength at each.
    on_edge : ndarray of bool, shape (N,)
        Which are on an edge; see `is_on_edge`.
    cells : Cells
        The particles sorted into cells, for neighbors up to a distance.
    """

    strength: Array
    on_edge: Mask
    cells: Cells


@compiled
def is_on_edge(squared: float, strength: float, floor: float) -> bool:
    """Whether a particle is on an edge: the Lorentz force is weak, and the edge strength at least `floor`.

    `squared` is the squared length of the interpolated Lorentz force, which is of unit size away from edges and below
    the gate on an edge.
    """
    return squared < GATE**2 and strength >= floor
