"""Small pictures of an image with contours, as the export shows them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen, QPixmap, QTransform

from app.model.display.display_image import DisplayImage
from app.views.canvas.items.item import to_xy
from app.views.theme import theme
from app.views.theme.theme import look
from cpm_core import Contour

_LINE, _HALO, _PALE = 1.7, 3.1, 1.0
_FILL = 150
"""Opacity of filled contours, of 255."""
_LEAST = 1000.0
"""Pixels along the longer side of the crop from which on the image is drawn reduced."""


@dataclass(frozen=True, slots=True)
class Line:
    """A contour and how it is drawn: in its own color unless another is given; pale ones are dashed."""

    contour: Contour
    color: str = ""
    filled: bool = False
    pale: bool = False


class Picture:
    """Draws the part `crop` [px] of an image with lines on it; without an image, the lines alone."""

    def __init__(self, display: DisplayImage | None, crop: QRectF) -> None:
        self._crop = crop
        self._image: QImage | None = None
        if display is None:
            return
        shades = display.reduced(_LEAST * max(display.shape) / max(crop.width(), crop.height(), 1.0))
        self._reduction = 1.0 if shades is display.shades else max(display.shape) / max(shades.shape[:2])
        gray = np.ascontiguousarray(shades)
        rows, cols = gray.shape[:2]
        kind = QImage.Format.Format_Grayscale8 if gray.ndim == 2 else QImage.Format.Format_RGB888
        self._image = QImage(gray.data, cols, rows, gray.strides[0], kind).copy()

    def drawn(self, room: QSize, ratio: float, lines: Iterable[Line]) -> QPixmap:
        """A picture as large as fits into a room."""
        size = QSizeF(self._crop.size()).scaled(QSizeF(room), Qt.AspectRatioMode.KeepAspectRatio)
        made = QPixmap((size * ratio).toSize().expandedTo(QSize(1, 1)))
        made.setDevicePixelRatio(ratio)
        made.fill(QColor(theme.CANVAS))
        painter = QPainter(made)
        painter.setRenderHints(QPainter.RenderHint.SmoothPixmapTransform | QPainter.RenderHint.Antialiasing)
        if self._image is not None:
            # The center of the first pixel of an image is (0, 0), as on the canvas.
            shrunk = QTransform.fromScale(1.0 / self._reduction, 1.0 / self._reduction)
            part = shrunk.mapRect(self._crop.translated(0.5, 0.5))
            painter.drawImage(QRectF(0.0, 0.0, size.width(), size.height()), self._image, part)
        zoom = size.width() / max(self._crop.width(), 1e-9)
        onto = QTransform(zoom, 0, 0, zoom, -zoom * self._crop.x(), -zoom * self._crop.y())
        _draw(painter, onto, tuple(lines))
        painter.end()
        return made


def _draw(painter: QPainter, onto: QTransform, lines: tuple[Line, ...]) -> None:
    paths = [onto.map(pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(line.contour.path)))) for line in lines]
    for line, path in zip(lines, paths, strict=True):
        if not (line.filled or line.pale):
            painter.strokePath(path, QPen(QColor(theme.HALO), _HALO))
    for line, path in zip(lines, paths, strict=True):
        default = look().color(theme.CLOSED if line.contour.closed else theme.OPEN)
        color = QColor(line.color or line.contour.color or default)
        if line.pale:
            painter.strokePath(path, QPen(color, _PALE, Qt.PenStyle.DashLine))
        else:
            painter.strokePath(path, QPen(color, _LINE))
        if line.filled:
            color.setAlpha(_FILL)
            painter.fillPath(path, color)
