"""Particles where edges are strong, in an area."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics import polyline
from cpm_core.numerics.types import Position
from cpm_core.particles.initialization import above
from cpm_core.shapes.checks import check_number
from cpm_core.shapes.path import ClosedPath

LOWEST, HIGHEST, _STEP = 0.02, 0.98, 0.02
"""Bounds of the fraction, and how much it is changed at a time."""


@dataclass(frozen=True, slots=True)
class Threshold(ClosedPath):
    """Particles where edges are strong, in an area; which positions they are depends on the image.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) of the area in px of the image, three different ones at least; the last is joined to the
        first.
    fraction : float
        Fraction of the largest edge strength in the area above which a pixel gets a particle.
    """

    title: ClassVar[str] = "threshold"
    follows_smoothing: ClassVar[bool] = True

    points: tuple[Position, ...]
    fraction: float = 0.3

    def __post_init__(self) -> None:
        ClosedPath.__post_init__(self)
        check_number("fraction", self.fraction, 0.0, 1.0)

    def seeds_for(
        self, values: NDArray[np.float64], strength: Callable[[], NDArray[np.float64]]
    ) -> NDArray[np.float64]:
        """Positions of its particles on an image, shape (N, 2); see `Everywhere.seeds_for`."""
        corner = np.array(values.shape) - 1
        low = np.clip(np.ceil(np.min(self.points, axis=0)), 0, corner).astype(int)
        high = np.clip(np.floor(np.max(self.points, axis=0)), 0, corner).astype(int)
        window = strength()[low[0] : high[0] + 1, low[1] : high[1] + 1]
        pixels = np.indices(window.shape).reshape(2, -1).T + low
        within = polyline.inside(self.points, pixels.astype(float)).reshape(window.shape)
        return above(np.where(within, window, 0.0), self.fraction) + low if within.any() else np.empty((0, 2))

    def resized(self, by: float) -> Threshold:
        """The same area with a threshold that is higher by so many steps of 0.02."""
        return replace(self, fraction=round(min(max(self.fraction + _STEP * by, LOWEST), HIGHEST), 6))
