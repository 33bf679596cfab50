"""A column of widgets that scrolls where there is too little height for it."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import QFrame, QScrollArea, QWidget


class Scroller(QScrollArea):
    """Scrolls its content up and down, on the background of what is around it."""

    def __init__(self, content: QWidget) -> None:
        super().__init__()
        self.setWidget(content)
        content.setAutoFillBackground(False)
        self.viewport().setAutoFillBackground(False)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)


_GAP = 5
"""Between the content and the scroll bar [px]."""


class Scrolled(Scroller):
    """Is as wide as its content; `least` is its minimum height [px]."""

    def __init__(self, content: QWidget, least: int) -> None:
        super().__init__(content)
        self._content = content
        self._least = least
        content.setObjectName("scrolled")

    def sizeHint(self) -> QSize:
        """The size of the content, with a scroll bar where it is needed."""
        content = self._content.sizeHint()
        return QSize(content.width() + self._bar(), content.height())

    def minimumSizeHint(self) -> QSize:
        """The least width of the content, and the given height."""
        return QSize(self._content.minimumSizeHint().width() + self._bar(), self._least)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Make room for the scroll bar and a gap beside it, or take it back."""
        super().resizeEvent(event)
        gap = _GAP if self._bar() else 0
        if self.viewportMargins().right() != gap:
            self.setViewportMargins(0, 0, gap, 0)
        if event.oldSize().height() != event.size().height():
            self.updateGeometry()

    def _bar(self) -> int:
        """Width of the scroll bar and its gap, 0 where there is none."""
        needed = self._content.minimumSizeHint().height() > self.height()
        return self.verticalScrollBar().sizeHint().width() + _GAP if needed else 0
