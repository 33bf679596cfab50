"""Which particles are near each other: a grid of cells, and the particles sorted by cell.

Cells begin at the outer side of the first pixels, -0.5 px, along every axis. The list itself has a field for every
coordinate, so that the loops over neighbors run on vector registers: see `plane`.
"""

from __future__ import annotations

from cpm_core.numerics.jit import compiled


@compiled
def cell_of(place: float, size: float, along: int) -> int:
    """Cell of side `size` [px] of a coordinate, of `along` cells; positions beyond belong to the outermost ones."""
    return int(min(max(int((place + 0.5) / size), 0), along - 1))
