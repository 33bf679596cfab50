"""The preview of the export: what the file will hold, and, pale, what it will not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPainterPath, QPaintEvent, QPen, QTransform
from PySide6.QtWidgets import QSizePolicy, QWidget

from app.model.display.display_image import DisplayImage, Shades
from app.model.text.language import tr
from app.views.canvas.items.item import to_xy
from app.views.theme import theme
from app.views.theme.look import look
from cpm_core.contours.contour import Contour
from cpm_core.formats.contours.contents import rgb
from cpm_core.formats.masks.labels import palette
from cpm_core.numerics.types import Array

_LINE, _HALO, _PALE = 1.6, 3.0, 1.0
_FILL = 150
"""Opacity of filled contours, of 255."""

_LARGEST = 2000
"""Side of the image from which on it is drawn reduced [px]."""

_SLIGHTLY = 0.3
"""Opacity of the image, on which contours stand out."""


class Preview(QWidget):
    """Draws an image with the contours of an export; `display` is the image, None without one."""

    def __init__(self, display: DisplayImage | None, shape: tuple[int, ...]) -> None:
        super().__init__()
        self._rows, self._cols = shape
        self._image = _picture(display.reduced(_LARGEST)) if display is not None else None
        self._written: Sequence[Contour] = ()
        self._left_out: Sequence[Contour] = ()
        self._bridges: Sequence[Array] = ()
        self._filled = False
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(300, 260)
        self.setAccessibleName(tr("Preview of the export"))

    def sizeHint(self) -> QSize:
        """Large enough to see single contours."""
        return QSize(460, 460)

    def show_export(
        self, written: Sequence[Contour], left_out: Sequence[Contour], bridges: Sequence[Array], filled: bool
    ) -> None:
        """Show contours that are written, filled or as lines, others that are not, and what was added to close some."""
        self._written, self._left_out, self._bridges, self._filled = written, left_out, bridges, filled
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the image and what lies on it."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), QColor("black"))
        size = QSizeF(self._cols, self._rows).scaled(QSizeF(self.size()), Qt.AspectRatioMode.KeepAspectRatio)
        placed = QRectF(QPointF(0.5 * (self.width() - size.width()), 0.5 * (self.height() - size.height())), size)
        painter.setClipRect(placed)
        if self._image is not None:
            painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
            painter.setOpacity(_SLIGHTLY if self._filled else 1.0)
            painter.drawImage(placed, self._image)
            painter.setOpacity(1.0)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        zoom = size.width() / self._cols  # the center of the first pixel is (0, 0)
        onto = QTransform(zoom, 0, 0, zoom, placed.x() + 0.5 * zoom, placed.y() + 0.5 * zoom)
        pale = QPen(QColor(look().color(theme.REJECTED)), _PALE, Qt.PenStyle.DashLine)
        for contour in self._left_out:
            painter.strokePath(onto.map(_path(contour.path)), pale)
        self._draw_written(painter, onto)
        for bridge in self._bridges:
            painter.strokePath(
                onto.map(_path(bridge)), QPen(QColor(look().color(theme.BRIDGE)), 1.4 * _LINE, Qt.PenStyle.DotLine)
            )
        painter.end()

    def _draw_written(self, painter: QPainter, onto: QTransform) -> None:
        paths = [onto.map(_path(contour.path)) for contour in self._written]
        if self._filled:
            colors = palette(min(255, len(paths)))[1:]
            for number in sorted(range(len(paths)), key=lambda index: -self._written[index].area):
                color = QColor(*colors[number % len(colors)].tolist())
                painter.strokePath(paths[number], QPen(color, _PALE))
                color.setAlpha(_FILL)
                painter.fillPath(paths[number], color)
            return
        for path in paths:
            painter.strokePath(path, QPen(QColor(theme.HALO), _HALO))
        for contour, path in zip(self._written, paths, strict=True):
            own = (
                QColor(*rgb(contour))
                if contour.color
                else QColor(look().color(theme.CLOSED if contour.closed else theme.OPEN))
            )
            painter.strokePath(path, QPen(own, _LINE))


def _picture(shades: Shades) -> QImage:
    gray = np.ascontiguousarray(shades)
    rows, cols = gray.shape[:2]
    kind = QImage.Format.Format_Grayscale8 if gray.ndim == 2 else QImage.Format.Format_RGB888
    return QImage(gray.data, cols, rows, gray.strides[0], kind).copy()


def _path(points: Array) -> QPainterPath:
    made: QPainterPath = pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(points)))
    return made
