"""A charge that a person places."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cpm_core.field.placed_charges import STRONGEST, PlacedCharge
from cpm_core.numerics.types import Position
from cpm_core.shapes.checks import check_number

WEAKEST, _STEP = 0.5, 0.5
"""Least strength, either way, and how much it is changed at a time."""


@dataclass(frozen=True, slots=True)
class Charge:
    """A charge that a person places; it acts on all particles within its reach at once.

    Attributes
    ----------
    position : tuple of float
        (row, col) in px of the image.
    strength : float
        Above zero it attracts particles, below it repels them; see `cpm_core.field.placed_charges`.
    """

    position: Position
    strength: float = 2.0

    def __post_init__(self) -> None:
        check_number("strength", self.strength, -STRONGEST, STRONGEST)

    @property
    def title(self) -> str:
        """What it is called."""
        return "attracting charge" if self.strength > 0 else "repelling charge"

    @property
    def placed(self) -> PlacedCharge:
        """As the engine takes it."""
        return PlacedCharge(self.position, self.strength)

    @property
    def outline(self) -> NDArray[np.float64]:
        """It has no line to be drawn."""
        return np.empty((0, 2))

    def moved(self, by: Position) -> Charge:
        """The same charge displaced by (rows, cols)."""
        return Charge((self.position[0] + by[0], self.position[1] + by[1]), self.strength)

    def resized(self, by: float) -> Charge:
        """The same place with a charge that is stronger by so many steps of a half."""
        size = min(max(abs(self.strength) + _STEP * by, WEAKEST), STRONGEST)
        return Charge(self.position, math.copysign(size, self.strength))

    def handles(self) -> tuple[Position, ...]:
        """It is dragged as a whole, so there are none."""
        return ()

    def with_handle_at(self, handle: Position, to: Position) -> Charge:
        """Itself, for it has no handles."""
        return self

    def distance(self, position: Position) -> float:
        """Distance of a position from it [px]."""
        return math.dist(self.position, position)

    def encloses(self, position: Position) -> bool:
        """It is taken hold of where it lies only."""
        return False
