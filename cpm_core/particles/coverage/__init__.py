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

from cpm_core.numerics.types import Array
from cpm_core.particles.cell_list import cell_of
from cpm_core.particles.coverage.tiled_steps import NEVER, Steps, TiledSteps

CELL = 4.0
"""Side of the cells of the coverage [px]."""

REACH = 4
"""Cells to each side within which a newly covered cell counts as near."""


class Coverage(NamedTuple):
    """Coverage of an image.

    Attributes
    ----------
    found : TiledSteps
        Step at which each cell was first covered.
    latest : TiledSteps
        Latest such step among the cells around each.
    size : int
        Number of covered cells.
    """

    found: TiledSteps
    latest: TiledSteps
    size: int

    @property
    def tiles(self) -> tuple[Steps, ...]:
        """All arrays, many of which other coverages share."""
        return self.found.tiles + self.latest.tiles


def no_coverage(shape: tuple[int, ...]) -> Coverage:
    """Coverage of an image of this shape before any particle has been on an edge."""
    never = TiledSteps.never(tuple(int(n / CELL) + 1 for n in shape))
    return Coverage(never, never, 0)


def coverage_of(found: Steps, latest: Steps) -> Coverage:
    r"""Coverage of which the steps are known as arrays of shape (\*cells), -1 for never."""
    never = TiledSteps.never(found.shape)
    return Coverage(never.changed_to(found), never.changed_to(latest), int(np.count_nonzero(found != NEVER)))


def renewed(coverage: Coverage, step: int) -> Coverage:
    """Coverage as if all covered cells had been newly covered at this step."""
    return Coverage(coverage.found.renewed(step), coverage.latest.renewed(step), coverage.size)


def renewed_near(coverage: Coverage, places: Array, reach: float, step: int) -> Coverage:
    """Coverage as if all cells within reach of positions, shape (K, D) [px], were near a newly covered cell."""
    latest = coverage.latest.whole()
    for place in places:
        parts, away = [], []
        for along, x in zip(latest.shape, place, strict=True):
            first, last = (cell_of(x + sign * reach, CELL, along) for sign in (-1, 1))
            parts.append(slice(first, last + 1))
            middle = CELL * (np.arange(first, last + 1) + 0.5) - 0.5
            away.append(np.maximum(np.abs(middle - x) - 0.5 * CELL, 0.0) ** 2)
        latest[tuple(parts)][reduce(np.add.outer, away) < reach**2] = step
    return coverage._replace(latest=coverage.latest.changed_to(latest))
