"""A label of one line that knows whether its whole text is visible."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QSizePolicy

from app.views.widgets.containers import ElidedLabel

_NARROWEST = 40


class FittingLabel(ElidedLabel):
    """Shows the first line of its text as far as it fits; the tool tip has the whole where it does not."""

    fits_changed = Signal()
    """The text fits now, or no longer."""

    def __init__(self) -> None:
        super().__init__()
        self.setTextFormat(Qt.TextFormat.PlainText)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self._fitted = True

    @property
    def fits(self) -> bool:
        """Whether the whole text is visible."""
        text = self.text()
        return "\n" not in text and self.fontMetrics().horizontalAdvance(text) <= self.contentsRect().width()

    def setText(self, text: str) -> None:
        """Show another text."""
        super().setText(text)
        self._follow()

    def minimumSizeHint(self) -> QSize:
        """It may be narrow."""
        return QSize(_NARROWEST, self.fontMetrics().height())

    def sizeHint(self) -> QSize:
        """Space for its first line."""
        return QSize(self.fontMetrics().horizontalAdvance(self.first_line) + 2, self.fontMetrics().height())

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Look whether the text fits."""
        super().resizeEvent(event)
        self._follow()

    def _follow(self) -> None:
        fits = self.fits
        self.setToolTip("" if fits else self.text())
        if fits != self._fitted:
            self._fitted = fits
            self.fits_changed.emit()
