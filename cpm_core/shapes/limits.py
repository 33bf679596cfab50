"""A region of interest, which particles do not leave."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cpm_core.numerics.types import Position
from cpm_core.shapes.path import Area


@dataclass(frozen=True, slots=True)
class Region(Area):
    """A region of interest, which particles do not leave.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image, at least three; the last is joined to the first.
    """

    title: ClassVar[str] = "region of interest"

    points: tuple[Position, ...]

    def encloses(self, position: Position) -> bool:
        """It is taken hold of by its line only, for what is drawn lies within it."""
        return False
