"""Deletion of particles of a volume that are too near to others of their sheet."""

from __future__ import annotations

from functools import partial

import numpy as np

from cpm_core.dynamics.deletion import NEAR, by_strength
from cpm_core.dynamics.edge_contact.space import on_one_sheet
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.numerics.vectors import difference, length, row_of
from cpm_core.particles.cell_list.space import Cells, cells_around, row_of_cells
from cpm_core.particles.state import Particles

_WORTH_A_THREAD = 2_000
"""Particles from which a second thread makes the search faster."""


def thinned(particles: Particles, cells: Cells, turn: Index, d_min: float) -> Mask:
    """Which particles stay, shape (N,).

    Of two nearer than ``d_min / 2`` the one on the weaker edge is deleted, and of equal ones the later, unless both are
    seated, on different sheets. Only those that have their `turn` have moved since the last use.
    """
    kept = np.ones(len(particles), np.bool_)
    contact = particles.contact
    assert contact is not None
    sheets = (particles.position, contact.normal, contact.seated)
    share(partial(_find_close, cells, turn, *sheets, NEAR * d_min, kept), len(turn), _WORTH_A_THREAD)
    close = np.flatnonzero(~kept)
    if len(close):
        _thin(cells, by_strength(close, contact.strength), *sheets, NEAR * d_min, kept)
    return kept


@compiled
def _find_close(
    cells: Cells,
    turn: Index,
    position: Array,
    normals: Array,
    seated: Mask,
    distance: float,
    alone: Mask,
    first: int,
    last: int,
) -> None:
    """Mark the particles with another one nearer than a distance as not alone; one of each pair has its turn."""
    for q in range(first, last):
        i = turn[q]
        place = row_of(position, i)
        top, bottom, front, back, left, right = cells_around(cells, place[0], place[1], place[2], distance)
        for plane in range(top, bottom + 1):
            for row in range(front, back + 1):
                start, end = row_of_cells(cells, plane, row, left, right)
                for k in range(start, end):
                    j = cells.order[k]
                    away = length(difference(place, (cells.z[k], cells.y[k], cells.x[k])))
                    if away < distance and j != i and on_one_sheet(i, j, normals, seated):
                        alone[i] = alone[j] = False


@compiled
def _thin(
    cells: Cells, order: Index, position: Array, normals: Array, seated: Mask, distance: float, kept: Mask
) -> None:
    """Of the particles in `order` keep those that have no kept one nearer than a distance."""
    for n in range(len(order)):
        kept[order[n]] = not _has_near(cells, order[n], position, normals, seated, distance, kept)


@compiled
def _has_near(
    cells: Cells, i: int, position: Array, normals: Array, seated: Mask, distance: float, counting: Mask
) -> bool:
    """Whether a particle has another one of its sheet nearer than a distance among those that count."""
    place = row_of(position, i)
    top, bottom, front, back, left, right = cells_around(cells, place[0], place[1], place[2], distance)
    for plane in range(top, bottom + 1):
        for row in range(front, back + 1):
            start, end = row_of_cells(cells, plane, row, left, right)
            for k in range(start, end):
                j = cells.order[k]
                away = length(difference(place, (cells.z[k], cells.y[k], cells.x[k])))
                if away < distance and j != i and counting[j] and on_one_sheet(i, j, normals, seated):
                    return True
    return False
