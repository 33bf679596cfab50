"""A field on the canvas for the name of a contour or an object."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import Qt
from PySide6.QtGui import QFocusEvent, QKeyEvent
from PySide6.QtWidgets import QLineEdit

from app.views.canvas.canvas import Canvas
from app.views.widgets.containers import keep_escape
from cpm_core.numerics import Position

_WIDTH = 170


class NameField(QLineEdit):
    """Asks for the name of something on the canvas: Enter accepts it, Esc changes nothing.

    `title` says what is named.
    """

    def __init__(self, canvas: Canvas, title: str) -> None:
        super().__init__(canvas)
        self._canvas = canvas
        self._accept: Callable[[str], None] | None = None
        self.setFixedWidth(_WIDTH)
        self.setPlaceholderText(title)
        self.setAccessibleName(title)
        keep_escape(self)
        self.hide()
        self.returnPressed.connect(self._give)

    def ask(self, place: Position, name: str, accept: Callable[[str], None], *, above: bool = False) -> None:
        """Ask for a name at a place (row, col) of the image, or above it.

        `name` is the present one, and `accept` takes the new one.
        """
        self._accept = accept
        at = self._canvas.point(place).toPoint()
        room = self._canvas.size() - self.sizeHint()
        self.move(
            min(max(at.x() - _WIDTH // 2, 4), max(4, self._canvas.width() - _WIDTH - 4)),
            min(max(at.y() - (12 + self.sizeHint().height() if above else 12), 4), max(4, room.height() - 4)),
        )
        self.setText(name)
        self.selectAll()
        self.show()
        self.raise_()
        self.setFocus()

    def leave(self) -> None:
        """Ask no longer, and change nothing."""
        self._accept = None
        had = self.hasFocus()
        self.hide()
        if had:
            self._canvas.setFocus()

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Cancel with Esc."""
        if event.key() == Qt.Key.Key_Escape:
            self.leave()
        else:
            super().keyPressEvent(event)
            event.accept()  # keys that the field does not use must not reach the canvas

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Accept the name when the focus moves elsewhere."""
        super().focusOutEvent(event)
        if event.reason() != Qt.FocusReason.PopupFocusReason and self.isVisible():
            self._give()

    def _give(self) -> None:
        accept, self._accept = self._accept, None
        if accept is not None:
            accept(self.text())
        self.leave()
