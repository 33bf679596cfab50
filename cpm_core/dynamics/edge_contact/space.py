"""Edge contact in a volume: which particles are seated on a surface."""

from __future__ import annotations

from cpm_core.field.volume.surface_force import GATE, faces_alike
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.types import Array, Mask
from cpm_core.numerics.vectors import row_of


@compiled
def is_seated(slope: float, near: float, strength: float, floor: float) -> bool:
    """Whether a particle is on the ridge of an edge that is strong enough.

    `slope` is the relative slope of the edge map along the normal, to which that of placed charges is added, `near` how
    much of the force it is.
    """
    return near >= 1.0 and abs(slope) < GATE and strength >= floor


@compiled
def on_one_sheet(i: int, j: int, normals: Array, seated: Mask) -> bool:
    """Whether two particles count as neighbors: those that are seated, only if they are on the same sheet."""
    return not (seated[i] and seated[j]) or faces_alike(row_of(normals, i), row_of(normals, j))
