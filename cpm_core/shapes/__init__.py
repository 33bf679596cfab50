"""The shapes that a person draws: starts, which give particles; limits, which hold them back; and placed charges.

Each is frozen, checks itself, knows how it is moved, resized and reshaped by its handles, and how far off a position
lies; none knows of a window. A new one is a module of its own and a place in the unions and in `SHAPES` below. By its
fields it is then kept in session files; a start gives particles on the command line as well. A limit also needs its
place in `document_shapes.regions_of`. For the window to draw it: a tool (`app.views.canvas.tools`), its look in the
layer of what is drawn (`app.views.canvas.layers.drawn`), and words for what can be done to it
(`app.model.state.resolve`).
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from cpm_core.shapes.charge import Charge
from cpm_core.shapes.circle import SMALLEST_RADIUS, Circle
from cpm_core.shapes.ellipse import Ellipse
from cpm_core.shapes.everywhere import KINDS, Everywhere, Kind
from cpm_core.shapes.grid import Grid
from cpm_core.shapes.limits import Barrier, Region
from cpm_core.shapes.points import Points
from cpm_core.shapes.polygon import Polygon
from cpm_core.shapes.stroke import Stroke
from cpm_core.shapes.threshold import Threshold

Start = Circle | Ellipse | Polygon | Stroke | Points | Grid | Threshold | Everywhere
"""Shapes that give particles."""

Limit = Region | Barrier
"""Shapes that hold particles back."""

Shape = Start | Limit | Charge

SHAPES: Mapping[str, type[Shape]] = MappingProxyType(
    {
        kind.__name__.lower(): kind
        for kind in (
            Circle,
            Ellipse,
            Polygon,
            Stroke,
            Points,
            Grid,
            Threshold,
            Everywhere,
            Region,
            Barrier,
            Charge,
        )
    }
)
"""Shapes by the names under which files keep them."""

__all__ = [
    "KINDS",
    "SHAPES",
    "SMALLEST_RADIUS",
    "Barrier",
    "Charge",
    "Circle",
    "Ellipse",
    "Everywhere",
    "Grid",
    "Kind",
    "Limit",
    "Points",
    "Polygon",
    "Region",
    "Shape",
    "Start",
    "Stroke",
    "Threshold",
]
