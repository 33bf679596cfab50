"""Deletion of particles of the plane that are too near to others."""

from __future__ import annotations

from functools import partial

import numpy as np

from cpm_core.dynamics.deletion import NEAR, by_strength
from cpm_core.dynamics.edge_contact import EdgeContact
from cpm_core.numerics.jit import compiled
from cpm_core.numerics.parallel import share
from cpm_core.numerics.types import Array, Index, Mask
from cpm_core.particles.cell_list.plane import Cells, build_cells, cells_around, row_of_cells

_LEAST_CELL = 4.0
"""Least side of a cell, which limits the memory however small the distance of the search [px]."""

_WORTH_A_THREAD = 10_000
"""Particles from which a second thread makes the search faster."""


def deletion(positions: Array, strength: Array, shape: tuple[int, ...], d_min: float) -> Mask:
    """Which of the particles at `positions`, shape (N, 2), stay, shape (N,), on an image of this shape.

    Of two nearer than ``d_min / 2`` [px] the one on the weaker edge is deleted; with equal `strength`, shape (N,), the
    later one.
    """
    places = np.ascontiguousarray(positions, dtype=float)
    cells = build_cells(places, shape, max(d_min, _LEAST_CELL))
    every = np.ones(len(places), np.bool_)
    return thinned(EdgeContact(strength, every, cells), every, d_min)


def thinned(contact: EdgeContact, has_moved: Mask, d_min: float) -> Mask:
    """Which particles stay, shape (N,), by the rule of `deletion`, where only some have moved since its last use.

    `has_moved`, shape (N,), marks the particles that have moved or are new.
    """
    count = len(contact.strength)
    kept = np.ones(count, np.bool_)
    share(partial(_find_close, contact.cells, has_moved, NEAR * d_min, kept), count, _WORTH_A_THREAD)
    close = np.flatnonzero(~kept)
    if len(close):
        _thin(contact.cells, by_strength(close, contact.strength), NEAR * d_min, kept)
    return kept


@compiled
def _find_close(cells: Cells, has_moved: Mask, distance: float, alone: Mask, first: int, last: int) -> None:
    """Mark the particles with another one nearer than a distance as not alone; one of each pair has moved."""
    for k in range(first, last):
        if not has_moved[cells.order[k]]:
            continue
        y, x = cells.y[k], cells.x[k]
        top, bottom, left, right = cells_around(cells, y, x, distance)
        for row in range(top, bottom + 1):
            start, end = row_of_cells(cells, row, left, right)
            for other in range(start, end):
                squared = (cells.y[other] - y) ** 2 + (cells.x[other] - x) ** 2
                if squared < distance * distance and other != k:
                    alone[cells.order[k]] = alone[cells.order[other]] = False


@compiled
def _thin(cells: Cells, order: Index, distance: float, kept: Mask) -> None:
    """Of the particles in `order` keep those that have no kept one nearer than a distance."""
    sorted_as = np.empty(len(cells.order), np.int64)
    for k in range(len(cells.order)):
        sorted_as[cells.order[k]] = k
    for n in range(len(order)):
        kept[order[n]] = not _has_near(cells, sorted_as[order[n]], distance, kept)


@compiled
def _has_near(cells: Cells, k: int, distance: float, counting: Mask) -> bool:
    """Whether one of the sorted particles has another one nearer than a distance among those that count."""
    y, x = cells.y[k], cells.x[k]
    top, bottom, left, right = cells_around(cells, y, x, distance)
    for row in range(top, bottom + 1):
        first, last = row_of_cells(cells, row, left, right)
        for other in range(first, last):
            squared = (cells.y[other] - y) ** 2 + (cells.x[other] - x) ** 2
            if squared < distance * distance and other != k and counting[cells.order[other]]:
                return True
    return False
