"""A charge that the user places."""

from __future__ import annotations

import math
import operator

from cpm_core.field.placed_charges import MAX_CHARGE_STRENGTH, PlacedCharge
from cpm_core.numerics.types import Place, frozen
from cpm_core.shapes.path import WithoutOutline, check_number

MIN_CHARGE_STRENGTH = 0.5
"""Least absolute strength."""

_CHARGE_STRENGTH_STEP = 0.5
"""Change of the absolute strength at a time."""


@frozen
class Charge(WithoutOutline):
    """Placed charge; it acts on all particles within its reach at once.

    Attributes
    ----------
    position : tuple of float
        (row, col) [px], or (plane, row, col) in a volume [voxels].
    strength : float
        Above zero it attracts particles, below it repels them; see `cpm_core.field.placed_charges`.
    """

    position: Place
    strength: float = 2.0

    def __post_init__(self) -> None:
        check_number("strength", self.strength, -MAX_CHARGE_STRENGTH, MAX_CHARGE_STRENGTH)

    @property
    def title(self) -> str:
        """Name for the user."""
        return "attracting charge" if self.strength > 0 else "repelling charge"

    @property
    def placed_charge(self) -> PlacedCharge:
        """The charge as the engine takes it."""
        return PlacedCharge(self.position, self.strength)

    def translated(self, offset: Place) -> Charge:
        """Return the charge displaced along each axis."""
        return Charge(tuple(map(operator.add, self.position, offset)), self.strength)

    def resized_by(self, by: float) -> Charge:
        """Return the charge with its absolute strength raised by a number of steps of a half."""
        size = min(max(abs(self.strength) + _CHARGE_STRENGTH_STEP * by, MIN_CHARGE_STRENGTH), MAX_CHARGE_STRENGTH)
        return Charge(self.position, math.copysign(size, self.strength))

    def distance_to(self, position: Place) -> float:
        """Measure the distance of a position from the charge [px]."""
        return math.dist(self.position, position)
