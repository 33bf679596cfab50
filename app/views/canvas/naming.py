"""A field on the canvas for the name of a contour."""

from __future__ import annotations

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QFocusEvent, QKeyEvent
from PySide6.QtWidgets import QLineEdit

from app.model.text.language import tr
from app.session.features.contour_review import ContourReview
from app.views.canvas.canvas import Canvas
from cpm_core.contours.review import middle

_WIDTH = 170


class NameField(QLineEdit):
    """Asks for the name of one contour of a review: Enter accepts it, Esc changes nothing."""

    def __init__(self, canvas: Canvas, review: ContourReview) -> None:
        super().__init__(canvas)
        self._canvas = canvas
        self._review = review
        self._key: int | None = None
        self.setFixedWidth(_WIDTH)
        self.setPlaceholderText(tr("Name of the contour"))
        self.setAccessibleName(tr("Name of the contour"))
        self.hide()
        self.returnPressed.connect(self._give)

    def ask(self, key: int) -> None:
        """Ask for the name of a contour, beside it."""
        self._key = key
        contour = self._review[key].contour
        at = self._canvas.point(middle(contour)).toPoint()
        room = self._canvas.size() - self.sizeHint()
        self.move(
            min(max(at.x() - _WIDTH // 2, 4), max(4, self._canvas.width() - _WIDTH - 4)),
            min(max(at.y() - 12, 4), max(4, room.height() - 4)),
        )
        self.setText(contour.name)
        self.selectAll()
        self.show()
        self.raise_()
        self.setFocus()

    def event(self, event: QEvent) -> bool:
        """While a name is written, Esc is not a shortcut of the window."""
        override = event.type() == QEvent.Type.ShortcutOverride
        if override and isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_Escape:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Cancel with Esc."""
        if event.key() == Qt.Key.Key_Escape:
            self._leave()
        else:
            super().keyPressEvent(event)
            event.accept()  # keys that the field does not use must not reach the canvas

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Accept the name when the focus moves elsewhere."""
        super().focusOutEvent(event)
        if event.reason() != Qt.FocusReason.PopupFocusReason and self.isVisible():
            self._give()

    def _give(self) -> None:
        key, self._key = self._key, None
        if key is not None:
            self._review.rename(key, self.text())
        self._leave()

    def _leave(self) -> None:
        self._key = None
        had = self.hasFocus()
        self.hide()
        if had:
            self._canvas.setFocus()
