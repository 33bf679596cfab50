"""The tool that draws ellipses."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt

from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.tools.dragged import Dragged
from cpm_core.numerics.types import Position
from cpm_core.shapes import SMALLEST_RADIUS, Ellipse


class EllipseTool(Dragged):
    """Draws an ellipse from corner to corner of its box; with Ctrl from its centre, with Shift as a circle."""

    name = "ellipse"
    activity = tr("draw ellipse")
    slip = tr("Keep the button down and drag to draw an ellipse.")
    guidance = tr("Drag a box around the ellipse; Shift makes it round, Ctrl draws it from its centre.")
    by_keys = tr("Enter begins at a corner of its box, arrow keys lead the opposite one, Enter ends.")

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._held = Qt.KeyboardModifier.NoModifier

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """Remember the keys."""
        self._held = modifiers

    def shape(self, begin: Position, at: Position) -> Ellipse:
        """The ellipse in the box, whose first radius lies along the row."""
        down, right = at[0] - begin[0], at[1] - begin[1]
        if self._held & Qt.KeyboardModifier.ShiftModifier:
            size = max(abs(down), abs(right))
            down, right = math.copysign(size, down), math.copysign(size, right)
        share, center = 1.0, begin
        if not self._held & Qt.KeyboardModifier.ControlModifier:
            share, center = 0.5, (begin[0] + 0.5 * down, begin[1] + 0.5 * right)
        return Ellipse(center, (max(share * abs(right), SMALLEST_RADIUS), max(share * abs(down), SMALLEST_RADIUS)))
