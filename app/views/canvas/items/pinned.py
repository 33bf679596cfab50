"""Items that do not move with the image: legends and bars, on a dark background that is readable on any image."""

from __future__ import annotations

from PySide6.QtCore import QPointF, QRectF, QSizeF
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter
from PySide6.QtWidgets import QApplication, QGraphicsObject, QStyleOptionGraphicsItem, QWidget

from app.views.canvas.items.item import cached

MARGIN = 12.0
"""Distance from the border of the canvas [px of the screen]."""

BACKGROUND, INK, FAINT = "#cc101216", "#f2f4f7", "#b6bec9"
"""Colors behind text, of text, and of less important text."""

_Z = 20.0


class Pinned(QGraphicsObject):
    """An item with a size in px of the screen; subclasses draw in `draw`, unless the size is empty."""

    def __init__(self) -> None:
        super().__init__()
        self._size = QSizeF()
        self.setZValue(_Z)
        self.setVisible(False)
        cached(self)

    @property
    def size(self) -> QSizeF:
        """Size [px of the screen]."""
        return self._size

    def resize(self, size: QSizeF) -> None:
        """Set the size and redraw."""
        if size != self._size:
            self.prepareGeometryChange()
            self._size = size
        self.update()

    def put(self, corner: QPointF) -> None:
        """Move the upper left corner to a point of the canvas, rounded to whole px to keep the text sharp."""
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
        """The area that is drawn on."""
        return QRectF(QPointF(0.0, 0.0), self._size)

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the background and the content."""
        if self._size.isEmpty():
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QColor(0, 0, 0, 0))
        painter.setBrush(QColor(BACKGROUND))
        painter.drawRoundedRect(self.boundingRect(), 5.0, 5.0)
        painter.setFont(self.font())
        self.draw(painter)

    def draw(self, painter: QPainter) -> None:
        """Draw the content."""
        raise NotImplementedError
