"""Names beside what they belong to, on the canvas."""

from __future__ import annotations

from collections.abc import Sequence

from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from app.views.canvas.items.item import OverImage
from app.views.theme import theme
from cpm_core.numerics.types import Position

_PAD = 4.0
_RIM = 300.0
"""Room around the image for what is written beyond its border [px of the image]."""


class Names(OverImage):
    """Texts of one size at positions of the image, whatever the zoom.

    Parameters
    ----------
    z : float
        Place in the pile of layers.
    """

    def __init__(self, z: float) -> None:
        super().__init__(z, _RIM)
        self._wanted = True
        self.texts: tuple[tuple[Position, str, str], ...] = ()
        self.setVisible(False)

    def show(self, texts: Sequence[tuple[Position, str, str]]) -> None:
        """Show texts: where (row, col), what, and in which color."""
        if texts or self.texts:
            self.texts = tuple(texts)
            self.update()
            self.set_wanted(self._wanted)

    def set_wanted(self, wanted: bool) -> None:
        """Say whether they are to be seen."""
        self._wanted = wanted
        self.setVisible(wanted and bool(self.texts))

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Write each on a dark ground, above its place."""
        transform = painter.worldTransform()
        font = QFont(painter.font())
        font.setWeight(QFont.Weight.DemiBold)
        metrics = QFontMetricsF(font)
        painter.save()
        painter.resetTransform()
        painter.setFont(font)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for (row, col), text, color in self.texts:
            at = transform.map(QPointF(col, row))
            width, height = metrics.horizontalAdvance(text) + 2 * _PAD, metrics.height() + _PAD
            room = QRectF(at.x() - width / 2, at.y() - height / 2, width, height)
            ground = QColor(theme.HALO)
            ground.setAlpha(205)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(ground)
            painter.drawRoundedRect(room, 4.0, 4.0)
            painter.setPen(QColor(color))
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter, text)
        painter.restore()
