"""The legend of the colors of particles, in the lower right corner of the canvas."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter

from app.model.text.language import tr
from app.views.canvas.items.pinned import INK, MARGIN, Pinned
from app.views.theme import color_maps, theme

BEGIN = 0.18
"""Part of the maps that is too dark to be told from a dark image."""

UNKNOWN = theme.JUNCTION
"""Color of particles of which the quantity is not known yet; it is in none of the maps."""

_WIDTH, _STRIP, _PAD = 170.0, 8.0, 8.0


class ColorLegend(Pinned):
    """A title, a strip of colors, and the values at its ends.

    Parameters
    ----------
    view : pg.ViewBox
        In whose corner it lies.
    """

    def __init__(self, view: pg.ViewBox) -> None:
        super().__init__()
        self._view = view
        self._words = ("", "", "")
        self._partly = False
        self._map = color_maps.GRAY
        view.sigResized.connect(self._place)

    @property
    def words(self) -> tuple[str, str, str]:
        """Title, least and most, as shown."""
        return self._words

    def show_range(self, title: str, low: float, high: float, map_name: str, partly: bool) -> None:
        """Show a range, of something that may be known only of a part of the particles.

        Nothing is done when it is what is shown.
        """
        words = (title, f"{low:g}", f"{high:g}")
        if (words, map_name, partly) != (self._words, self._map, self._partly):
            self._words, self._map, self._partly = words, map_name, partly
            self.resize(QSizeF(_WIDTH, 2 * self.metrics().height() + _STRIP + 2 * _PAD))
            self._place()

    def draw(self, painter: QPainter) -> None:
        """Draw it."""
        line = self.metrics().height()
        inner = self.boundingRect().adjusted(_PAD, 0.5 * _PAD, -_PAD, -0.5 * _PAD)
        title, low, high = self._words
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
