"""A charge that the user places."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cpm_core.field.placed_charges import STRONGEST, PlacedCharge
from cpm_core.numerics.types import Position
from cpm_core.shapes.path import WithoutOutline, check_number

WEAKEST, _STEP = 0.5, 0.5
"""Least absolute strength, and how much it changes at a time."""


@dataclass(frozen=True, slots=True)
class Charge(WithoutOutline):
    """A placed charge; it acts on all particles within its reach at once.

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
        """Name for the user."""
        return "attracting charge" if self.strength > 0 else "repelling charge"

    @property
    def placed(self) -> PlacedCharge:
        """The charge as the engine takes it."""
        return PlacedCharge(self.position, self.strength)

    def moved(self, by: Position) -> Charge:
        """The same charge displaced by (rows, cols)."""
        return Charge((self.position[0] + by[0], self.position[1] + by[1]), self.strength)

    def resized(self, by: float) -> Charge:
        """The charge with its absolute strength raised by so many steps of a half."""
        size = min(max(abs(self.strength) + _STEP * by, WEAKEST), STRONGEST)
        return Charge(self.position, math.copysign(size, self.strength))

    def distance(self, position: Position) -> float:
        """Distance of a position from the charge [px]."""
        return math.dist(self.position, position)
