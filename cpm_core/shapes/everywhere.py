"""Particles all over the image, which take no drawing."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from cpm_core.numerics.types import Position
from cpm_core.particles.initialization import STRONG, above, divergence_centers, uniform_grid

Kind = Literal["grid", "gradient", "centers"]
"""Where particles start that are not drawn: evenly, on strong edges, or where the electric field diverges."""

KINDS: tuple[Kind, ...] = get_args(Kind)

_TITLES: Mapping[Kind, str] = MappingProxyType(
    {"grid": "start everywhere", "gradient": "start on strong edges", "centers": "start at centers"}
)


@dataclass(frozen=True, slots=True)
class Everywhere:
    """Particles all over the image, at positions that depend on it (`cpm_core.shapes.image_starts`).

    Attributes
    ----------
    kind : {"grid", "gradient", "centers"}
        Evenly, on strong edges, or at the centers of divergence of the electric field.
    """

    kind: Kind

    @property
    def title(self) -> str:
        """What it is called."""
        return _TITLES[self.kind]

    @property
    def follows_smoothing(self) -> bool:
        """Whether its positions depend on the smoothing."""
        return self.kind == "gradient"

    def seeds_for(
        self, values: NDArray[np.float64], strength: Callable[[], NDArray[np.float64]]
    ) -> NDArray[np.float64]:
        """Positions of its particles on an image, shape (N, 2).

        Parameters
        ----------
        values : ndarray, shape (H, W)
            Gray values of the image.
        strength : callable
            Gives the edge strength of the image, shape (H, W).
        """
        if self.kind == "grid":
            return uniform_grid(values.shape)
        if self.kind == "gradient":
            return above(strength(), STRONG)
        return divergence_centers(values)

    @property
    def outline(self) -> NDArray[np.float64]:
        """It has no line to be drawn."""
        return np.empty((0, 2))

    def moved(self, by: Position) -> Everywhere:
        """Itself, for it has no place."""
        return self

    def resized(self, by: float) -> Everywhere:
        """Itself, for it has no size."""
        return self

    def handles(self) -> tuple[Position, ...]:
        """It has no size to drag, so there are none."""
        return ()

    def with_handle_at(self, handle: Position, to: Position) -> Everywhere:
        """Itself, for it has no handles."""
        return self

    def distance(self, position: Position) -> float:
        """Infinite: what has no place of its own would be in the way of all that is drawn."""
        return math.inf

    def encloses(self, position: Position) -> bool:
        """It encloses nothing, for the same reason."""
        return False
