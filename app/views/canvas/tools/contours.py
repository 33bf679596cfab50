"""The tool that selects contours."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication

from app.model.text.language import tr
from app.views.canvas.tools.tool import Cursor, Tool, ToolContext
from cpm_core.numerics.types import Position


class ContourTool(Tool):
    """Selects the contour under the pointer; with Shift or Ctrl it adds the contour to the selection or removes it."""

    name = "contours"
    tip = tr("Click a contour to select it; X rejects, K keeps, Enter names it.")
    clicks = True
    by_keys = tr("Enter selects the contour under it.")

    def __init__(self, context: ToolContext) -> None:
        super().__init__(context)
        self._review = context.review

    @property
    def advice(self) -> str:
        """What can be done with contours."""
        if self._review.selected:
            return tr("X rejects, K keeps, Enter names; Shift-click selects more.")
        return tr("Click a contour to select it.") if self._review.items else ""

    def press(self, at: Position, reach: float) -> None:
        """Select the contour under the pointer, or none."""
        key = self._review.under(at, reach)
        more = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier
        if not QGuiApplication.keyboardModifiers() & more:
            self._review.select(() if key is None else (key,))
        elif key is not None:
            self._review.select(self._review.selected ^ {key})

    def cancel(self) -> None:
        """Highlight no contour."""
        self._review.hover(None)

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A hand over a contour, which is also highlighted: the canvas asks after each move of the pointer."""
        key = self._review.under(at, reach)
        self._review.hover(key)
        return Cursor.ArrowCursor if key is None else Cursor.PointingHandCursor
