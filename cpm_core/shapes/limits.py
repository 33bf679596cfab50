"""Limits of a run: regions of interest, which particles do not leave, and barriers, which they do not cross."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from cpm_core.numerics.types import Position
from cpm_core.shapes.path import ClosedPath, OpenPath


@dataclass(frozen=True, slots=True)
class Region(ClosedPath):
    """A region of interest, which particles do not leave.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image, three different ones at least; the last is joined to the first.
    """

    title: ClassVar[str] = "region of interest"

    points: tuple[Position, ...]

    def encloses(self, position: Position) -> bool:
        """It is taken hold of by its line only, for what is drawn lies within it."""
        return False


@dataclass(frozen=True, slots=True)
class Barrier(OpenPath):
    """A line that particles do not cross.

    Attributes
    ----------
    points : tuple of tuple of float
        Corners (row, col) in px of the image, two different ones at least.
    """

    title: ClassVar[str] = "barrier"

    points: tuple[Position, ...]
