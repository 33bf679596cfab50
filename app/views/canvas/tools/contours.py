"""The tool that picks contours."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication

from app.model.text.language import tr
from app.session.features.contour_review import ContourReview
from app.views.canvas.tools.tool import Cursor, Momentary
from cpm_core.numerics.types import Position


class ContourTool(Momentary):
    """Selects the contour under the pointer; with Shift or Ctrl, one more or one less."""

    name = "contours"
    clicks = True
    by_keys = tr("Enter selects the contour under it.")

    def __init__(self, review: ContourReview) -> None:
        super().__init__()
        self._review = review

    @property
    def advice(self) -> str:
        """What can be done to contours."""
        if self._review.selected:
            return tr("X rejects, K keeps, Enter names; Shift-click selects more.")
        return tr("Click a contour to select it.") if self._review.items else ""

    def press(self, at: Position, reach: float) -> None:
        """Select what lies under the pointer, or nothing."""
        key = self._review.under(at, reach)
        more = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier
        if not QGuiApplication.keyboardModifiers() & more:
            self._review.select(() if key is None else (key,))
        elif key is not None:
            self._review.select(self._review.selected ^ {key})

    def drag(self, at: Position) -> None:
        """Nothing is moved."""

    def release(self) -> None:
        """Nothing is left to be done."""

    def cancel(self) -> None:
        """Highlight nothing any more."""
        self._review.hover(None)

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A hand over a contour, which is highlighted: it is asked for whenever the pointer moves."""
        key = self._review.under(at, reach)
        self._review.hover(key)
        return Cursor.ArrowCursor if key is None else Cursor.PointingHandCursor
