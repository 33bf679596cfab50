"""What is written over the view in space: the names of the axes, and a scale bar."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QPainter, QPen

from app.model.display.lengths import bar
from app.model.display.space.camera import Camera
from app.model.display.space.view_in_space import AXIS_COLORS, ViewInSpace
from app.model.text.language import tr
from app.model.volume.slices import Ends
from app.views.theme import theme

_LONGEST, _MARGIN, _TICK = 120.0, 14.0, 4.0
"""Largest length of the scale bar, its distance from the corner, and the height of its ends [px of the screen]."""

_BEYOND = 12.0
"""Distance of a name from the end of its axis [px of the screen]."""

_DIM = 150, 156, 166
"""Color of what is said while there is no picture."""


class SpaceMarks:
    """Names at both ends of each axis, and a bar in the volume's unit, px where it is not known."""

    def __init__(self) -> None:
        self.names: tuple[Ends, ...] = ()
        self.unit: str | None = None

    def draw(self, painter: QPainter, view: ViewInSpace, camera: Camera, size: QSize) -> None:
        """Draw over a picture of this size that the camera has taken."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if view.box:
            self._draw_names(painter, view, camera, size)
        self._draw_bar(painter, camera, size)

    def wait(self, painter: QPainter, size: QSize) -> None:
        """Say that the first picture is being made, which may take a while on a new computer."""
        painter.setPen(QColor(*_DIM))
        _write(painter, QPointF(0.5 * size.width(), 0.5 * size.height()), tr("The picture is being prepared."))

    def _draw_names(self, painter: QPainter, view: ViewInSpace, camera: Camera, size: QSize) -> None:
        sides = np.array(view.lengths)
        room = size.height(), size.width()
        for axis, names in enumerate(self.names):
            ends = np.zeros((2, 3))
            ends[1, axis] = sides[axis]
            seen = camera.seen(ends, room)[:, :2].astype(float)
            way = seen[1] - seen[0]
            length = float(np.hypot(*way))
            if length < 2.0 * _BEYOND:  # the axis points to the viewer
                continue
            painter.setPen(QColor(*AXIS_COLORS[axis]).lighter(130))
            for place, side, name in ((seen[0], -1.0, names[0]), (seen[1], 1.0, names[1])):
                col, row = place + side * _BEYOND * way / length
                _write(painter, QPointF(col, row), name)

    def _draw_bar(self, painter: QPainter, camera: Camera, size: QSize) -> None:
        scaled = bar(_LONGEST / camera.scale, 1.0, self.unit)
        length = scaled.pixels * camera.scale
        left, y = _MARGIN, size.height() - _MARGIN
        painter.setPen(QPen(QColor(theme.DRAWING), 2.0))
        painter.drawLine(QPointF(left, y), QPointF(left + length, y))
        for x in (left, left + length):
            painter.drawLine(QPointF(x, y - _TICK), QPointF(x, y + _TICK))
        _write(painter, QPointF(left + 0.5 * length, y - _MARGIN), scaled.label)


def _write(painter: QPainter, center: QPointF, text: str) -> None:
    """A text with its middle at a point."""
    metrics = painter.fontMetrics()
    room = QSizeF(metrics.horizontalAdvance(text) + 4.0, metrics.height())
    corner = center - QPointF(0.5 * room.width(), 0.5 * room.height())
    painter.drawText(QRectF(corner, room), Qt.AlignmentFlag.AlignCenter, text)
