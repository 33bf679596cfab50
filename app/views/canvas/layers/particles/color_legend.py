"""The legend of the colors of particles, in the lower right corner of the canvas."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter

from app.model.text.language import tr, written
from app.views.canvas.items.pinned import INK, MARGIN, Pinned
from app.views.theme import color_maps, theme

BEGIN = 0.18
"""Part of the maps that is too dark to be distinguished from a dark image."""

UNKNOWN = theme.JUNCTION
"""Color of particles whose quantity is not known yet; no map contains it."""

_WIDTH, _STRIP, _PAD = 170.0, 8.0, 8.0


class ColorLegend(Pinned):
    """A title, a strip of colors, and the values at its ends, in the corner of a view."""

    def __init__(self, view: pg.ViewBox) -> None:
        super().__init__()
        self._view = view
        self.words = ("", "", "")
        """Title, least and largest value, as shown."""
        self._partly = False
        self._map = color_maps.GRAY
        view.sigResized.connect(self._place)

    def show_range(self, title: str, low: float, high: float, map_name: str, partly: bool) -> None:
        """Show the range of a quantity; `partly` means that it is unknown for some particles."""
        words = (title, written(f"{low:g}"), written(f"{high:g}"))
        if (words, map_name, partly) != (self.words, self._map, self._partly):
            self.words, self._map, self._partly = words, map_name, partly
            self.resize(QSizeF(_WIDTH, 2 * self.metrics().height() + _STRIP + 2 * _PAD))
            self._place()

    def draw(self, painter: QPainter) -> None:
        """Draw title, strip and values."""
        line = self.metrics().height()
        inner = self.boundingRect().adjusted(_PAD, 0.5 * _PAD, -_PAD, -0.5 * _PAD)
        title, low, high = self.words
        painter.setPen(QColor(INK))
        painter.drawText(QRectF(inner.left(), inner.top(), inner.width(), line), Qt.AlignmentFlag.AlignHCenter, title)
        strip = QRectF(inner.left(), inner.top() + line + 2.0, inner.width(), _STRIP)
        pixels = color_maps.strip(self._map, 2 * round(strip.width()), 2 * round(strip.height()), BEGIN)
        painter.drawPixmap(strip, pixels, QRectF(pixels.rect()))
        below = QRectF(inner.left(), strip.bottom() + 1.0, inner.width(), line)
        painter.drawText(below, Qt.AlignmentFlag.AlignLeft, low)
        painter.drawText(below, Qt.AlignmentFlag.AlignRight, high)
        if self._partly:
            painter.setPen(QColor(UNKNOWN))
            painter.drawText(below, Qt.AlignmentFlag.AlignHCenter, tr("● too new"))

    def _place(self, *_: object) -> None:
        room = self._view.boundingRect()
        corner = room.bottomRight() - QPointF(self.size.width() + MARGIN, self.size.height() + MARGIN)
        self.put(corner)
