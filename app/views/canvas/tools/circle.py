"""The tool that draws circles."""

from __future__ import annotations

import math

from app.model.text.language import tr
from app.views.canvas.tools.dragged import Dragged
from cpm_core.numerics.types import Position
from cpm_core.shapes import SMALLEST_RADIUS, Circle


class CircleTool(Dragged):
    """Draws a circle from its centre."""

    name = "circle"
    activity = tr("draw circle")
    slip = tr("Keep the button down and drag to draw a circle from its centre.")
    by_keys = tr("Enter begins at the centre, arrow keys lead the rim, Enter ends.")

    def shape(self, begin: Position, at: Position) -> Circle:
        """The circle whose rim goes through the pointer."""
        return Circle(begin, max(math.dist(begin, at), SMALLEST_RADIUS))
