"""The coverage of a volume: where surfaces have been found, by cells and the side that they face.

A cell counts once for each side, so that the second wall of a thin object is new ground. The cells found are kept as a
sorted list: surfaces fill few of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cpm_core.numerics.types import Array, Index, Mask

_SIDE = np.array([1.0, 0.37, 0.21])
"""Direction that tells the sides of a surface apart: in no plane of a usual grid."""

_SPAN = 1 << 20
"""Cells along an axis that a number has room for."""


class SurfaceCoverage(NamedTuple):
    """Coverage of a volume.

    Attributes
    ----------
    cells : ndarray of int64, shape (K,)
        Numbers of the cells found, with their sides, in ascending order.
    side : float
        Side of a cell [units].
    """

    cells: Index
    side: float

    @property
    def size(self) -> int:
        """Number of cells found, each side for itself."""
        return len(self.cells)


def no_surface(side: float = 1.0) -> SurfaceCoverage:
    """The coverage before any surface has been found, with cells of this side [units]."""
    return SurfaceCoverage(np.zeros(0, np.int64), side)


def cells_of(places: Array, normals: Array, side: float) -> Index:
    """Number of the cell and side of each of some particles, shape (N,)."""
    cell = np.floor(places / side).astype(np.int64) + 1
    number = (cell[:, 0] * _SPAN + cell[:, 1]) * _SPAN + cell[:, 2]
    return np.asarray(2 * number + (normals @ _SIDE > 0.0))


def cover(coverage: SurfaceCoverage, places: Array, normals: Array) -> tuple[SurfaceCoverage, Mask]:
    """The coverage with the cells of seated particles, and which of these, shape (N,), are the first in theirs."""
    number = cells_of(places, normals, coverage.side)
    new, first = np.unique(number, return_index=True)
    place = np.searchsorted(coverage.cells, new)
    known = np.zeros(len(new), np.bool_)
    inside = place < len(coverage.cells)
    known[inside] = coverage.cells[place[inside]] == new[inside]
    fresh = np.zeros(len(places), np.bool_)
    fresh[first[~known]] = True
    return coverage._replace(cells=np.insert(coverage.cells, place[~known], new[~known])), fresh
