"""A label of one line that shows as much of its text as there is room for."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent, QResizeEvent
from PySide6.QtWidgets import QLabel, QSizePolicy


class ElidedLabel(QLabel):
    """The first line of a text, with an ellipsis where there is more."""

    fits_changed = Signal()
    """The whole text fits now, or no longer."""

    def __init__(self) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.fits = True

    def setText(self, text: str) -> None:
        """Show another text."""
        super().setText(text)
        self._follow()

    def minimumSizeHint(self) -> QSize:
        """One line, of any width."""
        return QSize(0, self.fontMetrics().height())

    def sizeHint(self) -> QSize:
        """Room for the first line."""
        return QSize(
            self.fontMetrics().horizontalAdvance(self.text().partition("\n")[0]) + 2, self.fontMetrics().height()
        )

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Look whether the text fits."""
        super().resizeEvent(event)
        self._follow()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw what fits."""
        painter = QPainter(self)
        painter.setPen(self.palette().color(self.foregroundRole()))
        first, more, _ = self.text().partition("\n")
        box = self.contentsRect()
        shown = self.fontMetrics().elidedText(f"{first} …" if more else first, Qt.TextElideMode.ElideRight, box.width())
        painter.drawText(box, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, shown)
        painter.end()

    def _follow(self) -> None:
        text, before = self.text(), self.fits
        self.fits = "\n" not in text and self.fontMetrics().horizontalAdvance(text) <= self.contentsRect().width()
        if self.fits != before:
            self.fits_changed.emit()
