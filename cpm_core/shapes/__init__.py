"""The shapes that a person draws: starts, which give particles, and limits, which hold particles back.

Each is frozen, knows how it is moved, grown and led by its handles, and how far off a position lies; none knows of a
window. A new one is a module of its own and a line in the unions below.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cpm_core.shapes.barrier import Barrier
from cpm_core.shapes.circle import SMALLEST_RADIUS, Circle
from cpm_core.shapes.everywhere import KINDS, Everywhere, Kind
from cpm_core.shapes.points import Points
from cpm_core.shapes.region import Region
from cpm_core.shapes.stroke import Stroke

Start = Circle | Points | Stroke | Everywhere
"""Shapes that give particles."""

Limit = Region | Barrier
"""Shapes that hold particles back."""

Shape = Start | Limit

SHAPES: Mapping[str, type[Shape]] = MappingProxyType(
    {kind.__name__.lower(): kind for kind in (Circle, Points, Stroke, Everywhere, Region, Barrier)}
)
"""Shapes by the names under which files keep them."""

__all__ = [
    "KINDS",
    "SHAPES",
    "SMALLEST_RADIUS",
    "Barrier",
    "Circle",
    "Everywhere",
    "Kind",
    "Limit",
    "Points",
    "Region",
    "Shape",
    "Start",
    "Stroke",
]
