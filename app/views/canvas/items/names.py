"""Names of objects on the canvas."""

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
"""Margin around the image for text beyond its border [px of the image]."""


class Names(OverImage):
    """Texts at positions of the image, of the same size at any zoom."""

    def __init__(self, z: float) -> None:
        super().__init__(z, _RIM)
        self.texts: tuple[tuple[Position, str, str], ...] = ()
        self.setVisible(False)

    def show(self, texts: Sequence[tuple[Position, str, str]]) -> None:
        """Show texts, each given by position (row, col), text and color."""
        if texts or self.texts:
            self.texts = tuple(texts)
            self.update()
            self.set_shown(self._shown)

    @property
    def empty(self) -> bool:
        """Whether there are no texts."""
        return not self.texts

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw each text on a dark background, centered on its position."""
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
            background = QColor(theme.HALO)
            background.setAlpha(205)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(background)
            painter.drawRoundedRect(room, 4.0, 4.0)
            painter.setPen(QColor(color))
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter, text)
        painter.restore()
