"""Coverage: where and when particles have first been on an edge.

The number of particles does not measure progress: particles gather and are deleted again. The number of covered cells
of the image does: it can only rise and is bounded. Particles without newly covered cells around them for some steps are
brought to rest, each neighborhood separately, so that every run ends and a distant front does not keep the others
moving.
"""

from __future__ import annotations

from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Array
from cpm_core.particles.cell_list import cell_of

Steps = NDArray[np.int32]

CELL = 4.0
"""Side of the cells of the coverage [px]."""

REACH = 4
"""Cells to each side within which a newly covered cell counts as near."""

NEVER = -1


class Coverage(NamedTuple):
    r"""Coverage of an image; a plain tuple for the compiled loops.

    Attributes
    ----------
    found : ndarray of int32, shape (\*cells)
        Step at which each cell was first covered, -1 for never.
    latest : ndarray of int32, shape (\*cells)
        Latest such step among the cells around each, -1 for never.
    """

    found: Steps
    latest: Steps

    @property
    def size(self) -> int:
        """Number of covered cells."""
        return int(np.count_nonzero(self.found != NEVER))


def no_coverage(shape: tuple[int, ...]) -> Coverage:
    """Coverage of an image of this shape before any particle has been on an edge."""
    cells = np.full(tuple(int(n / CELL) + 1 for n in shape), NEVER, np.int32)
    return Coverage(cells, cells)


def renewed(coverage: Coverage, step: int) -> Coverage:
    """Coverage as if all covered cells had been newly covered at this step."""
    return Coverage(*(np.where(cells == NEVER, NEVER, step).astype(np.int32) for cells in coverage))


def renewed_near(coverage: Coverage, places: Array, reach: float, step: int) -> Coverage:
    """Coverage as if all cells within reach of positions, shape (K, D) [px], were near a newly covered cell."""
    latest = coverage.latest.copy()
    for place in places:
        parts, away = [], []
        for along, x in zip(latest.shape, place, strict=True):
            first, last = (cell_of(x + sign * reach, CELL, along) for sign in (-1, 1))
            parts.append(slice(first, last + 1))
            middle = CELL * (np.arange(first, last + 1) + 0.5) - 0.5
            away.append(np.maximum(np.abs(middle - x) - 0.5 * CELL, 0.0) ** 2)
        latest[tuple(parts)][reduce(np.add.outer, away) < reach**2] = step
    return Coverage(coverage.found, latest)
