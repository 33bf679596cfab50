"""Particles spread evenly over an area."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics import polyline
from cpm_core.numerics.types import Position
from cpm_core.shapes.checks import check_number
from cpm_core.shapes.path import ClosedPath

FINEST, COARSEST = 2.0, 64.0
"""Least and largest distance between two particles [px]."""


@dataclass(frozen=True, slots=True)
class Grid(ClosedPath):
    """Particles spread evenly over an area.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) of the area in px of the image, three different ones at least; the last is joined to the
        first.
    spacing : float
        Distance from particle to particle along rows and columns [px].
    """

    title: ClassVar[str] = "grid"

    points: tuple[Position, ...]
    spacing: float = 8.0

    def __post_init__(self) -> None:
        ClosedPath.__post_init__(self)
        check_number("spacing", self.spacing)

    def seeds(self) -> NDArray[np.float64]:
        """Positions of its particles, shape (N, 2), laid from the middle of the area; one where it has no room."""
        low, high = np.min(self.points, axis=0), np.max(self.points, axis=0)
        height, width = (high - low).tolist()
        places = np.stack(
            np.meshgrid(_along(height, self.spacing), _along(width, self.spacing), indexing="ij"), axis=-1
        )
        places = places.reshape(-1, 2) + low
        found = places[polyline.inside(self.points, places)]
        return np.asarray(found if len(found) else np.mean(self.points, axis=0)[None])

    def resized(self, by: float) -> Grid:
        """The same area with so many px more between the particles."""
        return replace(self, spacing=min(max(self.spacing + by, FINEST), COARSEST))


def _along(length: float, spacing: float) -> NDArray[np.float64]:
    """Places as far from one end as from the other."""
    count = int(length // spacing) + 1
    return np.asarray(0.5 * length + spacing * (np.arange(count) - 0.5 * (count - 1)), dtype=float)
