"""Drawing operations for the illustrations of parameters, on a sheet of 128 × 72 in the colors of the canvas."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from PySide6.QtCore import QLineF, QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF

from app.views.theme import theme

WIDTH, HEIGHT = 128.0, 72.0

EDGE, PARTICLE, REST = "#8d97a5", theme.MOVING, theme.RESTING
CONTOUR, LOST, MARK = theme.CLOSED, "#5b6470", theme.OPEN

Point = tuple[float, float]
"""(x, y) on the sheet, y downward."""


class Sketch:
    """Drawing operations of illustrations, on a painter scaled to the size of the sheet."""

    def __init__(self, painter: QPainter) -> None:
        self._painter = painter

    def line(self, points: Sequence[Point], color: str, width: float = 1.4, *, dashed: bool = False, ink: float = 1.0
             ) -> None:  # fmt: skip
        """A line through points."""
        self._painter.setPen(_pen(color, width, dashed, ink))
        self._painter.setBrush(Qt.BrushStyle.NoBrush)
        self._painter.drawPolyline(QPolygonF([QPointF(x, y) for x, y in points]))

    def curve(self, law: Callable[[float], float], color: str, width: float = 1.4, *, low: float = 6.0,
              high: float = WIDTH - 6.0, ink: float = 1.0) -> None:  # fmt: skip
        """The graph of a function y(x)."""
        count = 60
        places = (low + (high - low) * n / count for n in range(count + 1))
        self.line([(x, law(x)) for x in places], color, width, ink=ink)

    def particle(self, x: float, y: float, color: str = PARTICLE, radius: float = 3.2, ink: float = 1.0) -> None:
        """A particle."""
        brush = QColor(color)
        brush.setAlphaF(max(0.0, min(1.0, ink)))
        self._painter.setPen(Qt.PenStyle.NoPen)
        self._painter.setBrush(brush)
        self._painter.drawEllipse(QPointF(x, y), radius, radius)

    def ring(self, x: float, y: float, across: float, down: float, color: str, width: float = 1.6, *, ink: float = 1.0
             ) -> None:  # fmt: skip
        """A closed contour."""
        self._painter.setPen(_pen(color, width, False, ink))
        self._painter.setBrush(Qt.BrushStyle.NoBrush)
        self._painter.drawEllipse(QPointF(x, y), across, down)

    def block(self, x: float, y: float, across: float, down: float, gray: float, line: str = "") -> None:
        """A rectangle at its upper left corner, with a gray value from 0 to 1 and an outline if `line` is a color."""
        value = round(255 * max(0.0, min(1.0, gray)))
        self._painter.setPen(_pen(line, 1.4, False, 1.0) if line else QPen(Qt.PenStyle.NoPen))
        self._painter.setBrush(QColor(value, value, value))
        self._painter.drawRect(QRectF(x, y, across, down))

    def arrow(self, x: float, y: float, length: float, color: str) -> None:
        """An arrow to the right, or to the left when its length is negative."""
        self._painter.setPen(_pen(color, 1.3, False, 1.0))
        tip, back = x + length, math.copysign(3.0, length)
        self._painter.drawLines([QLineF(x, y, tip, y), QLineF(tip, y, tip - back, y - 2.2),
                                 QLineF(tip, y, tip - back, y + 2.2)])  # fmt: skip

    def bracket(self, left: float, right: float, y: float, color: str = MARK) -> None:
        """A bracket below a span."""
        self.line([(left, y - 3), (left, y), (right, y), (right, y - 3)], color, 1.2)


def ease(t: float, start: float, end: float) -> float:
    """Zero before `start`, one after `end`, and smooth between."""
    share = max(0.0, min(1.0, (t - start) / (end - start)))
    return share * share * (3.0 - 2.0 * share)


def _pen(color: str, width: float, dashed: bool, ink: float) -> QPen:
    shade = QColor(color)
    shade.setAlphaF(max(0.0, min(1.0, ink)))
    pen = QPen(shade, width)
    pen.setCapStyle(Qt.PenCapStyle.RoundCap)
    pen.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
    if dashed:
        pen.setDashPattern([2.5, 2.5])
    return pen
