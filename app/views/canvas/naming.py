"""A field on the canvas in which a contour is named."""

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
    """Takes the name of one contour: Enter gives it, Esc leaves everything as it was.

    Parameters
    ----------
    canvas : Canvas
        What it lies on.
    review : ContourReview
        What it names.
    """

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
        """Esc is no key of the window as long as a name is written."""
        override = event.type() == QEvent.Type.ShortcutOverride
        if override and isinstance(event, QKeyEvent) and event.key() == Qt.Key.Key_Escape:
            event.accept()
            return True
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Esc gives up."""
        if event.key() == Qt.Key.Key_Escape:
            self._leave()
        else:
            super().keyPressEvent(event)
            event.accept()  # what the field has no use for is no key of the canvas either

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Whoever goes elsewhere is done with it."""
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
