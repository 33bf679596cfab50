"""What lies on the canvas and does not move with the image: legends and bars, on a dark ground that any image bears."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSizeF
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter
from PySide6.QtWidgets import QApplication, QStyleOptionGraphicsItem, QWidget

from app.views.canvas.items.item import cached

MARGIN = 12.0
"""Distance from the rim of the canvas [px of the screen]."""

GROUND, INK, FAINT = "#cc101216", "#f2f4f7", "#b6bec9"
"""Colors behind text, of text, and of what is less important."""

_Z = 20.0


class Pinned(pg.GraphicsObject):  # type: ignore[misc]  # pyqtgraph has no type hints
    """Something of a size in px of the screen, which subclasses draw in `draw`.

    Nothing is drawn while its size is empty.
    """

    def __init__(self) -> None:
        super().__init__()
        self._size = QSizeF()
        self.setZValue(_Z)
        self.setVisible(False)
        cached(self)

    @property
    def size(self) -> QSizeF:
        """Its size."""
        return self._size

    def resize(self, size: QSizeF) -> None:
        """Take on a size, and look anew."""
        if size != self._size:
            self.prepareGeometryChange()
            self._size = size
        self.update()

    def put(self, corner: QPointF) -> None:
        """Lay its upper left corner upon a point of the canvas, a whole one, for its text is sharp only there."""
        self.setPos(QPointF(round(corner.x()), round(corner.y())))

    def font(self) -> QFont:
        """Font of its text."""
        font = QApplication.font()
        font.setPointSizeF(max(7.0, font.pointSizeF() - 1.0))
        return font

    def metrics(self) -> QFontMetricsF:
        """Measures of its text."""
        return QFontMetricsF(self.font())

    def boundingRect(self) -> QRectF:
        """Room that is drawn on."""
        return QRectF(QPointF(0.0, 0.0), self._size)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the ground and what stands upon it."""
        if self._size.isEmpty():
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QColor(0, 0, 0, 0))
        painter.setBrush(QColor(GROUND))
        painter.drawRoundedRect(self.boundingRect(), 5.0, 5.0)
        painter.setFont(self.font())
        self.draw(painter)

    def draw(self, painter: QPainter) -> None:
        """Draw what stands upon the ground."""
        raise NotImplementedError
