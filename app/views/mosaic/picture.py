"""Painting of a part of an image with contours at any size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPainterPath, QPen, QTransform

from app.model.display.display_image import DisplayImage
from app.views.canvas.coordinates import to_xy
from app.views.theme import theme
from app.views.theme.look import look
from cpm_core.contours.contour import Contour

_LINE, _HALO = 1.8, 3.2

_LEAST = 1000.0
"""Pixels along the longer side of the crop from which on the image is drawn reduced."""


class Picture:
    """Draws the part `crop` [px] of an image, and contours, into rectangles."""

    def __init__(self, display: DisplayImage, crop: QRectF) -> None:
        shades = display.reduced(_LEAST * max(display.shape) / max(crop.width(), crop.height(), 1.0))
        self._size = 1.0 if shades is display.shades else max(display.shape) / max(shades.shape[:2])
        gray = np.ascontiguousarray(shades)
        rows, cols = gray.shape[:2]
        kind = QImage.Format.Format_Grayscale8 if gray.ndim == 2 else QImage.Format.Format_RGB888
        self._image = QImage(gray.data, cols, rows, gray.strides[0], kind).copy()
        self._crop = crop

    def placed_in(self, room: QRectF) -> QRectF:
        """The largest centered rectangle with the aspect ratio of the crop."""
        size = QSizeF(self._crop.size()).scaled(room.size(), Qt.AspectRatioMode.KeepAspectRatio)
        placed = QRectF(room.topLeft(), size)
        placed.moveCenter(room.center())
        return placed

    def draw(self, painter: QPainter, room: QRectF, contours: Sequence[Contour] = (), pale: bool = False) -> None:
        """Paint image and contours as large as fits; pale while the run is not finished."""
        placed = self.placed_in(room)
        painter.save()
        painter.setClipRect(placed)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.setOpacity(0.35 if pale else 1.0)
        # The center of the first pixel of an image is (0, 0), as on the canvas.
        part = self._crop.translated(0.5, 0.5)
        size = self._size
        painter.drawImage(
            placed, self._image, QRectF(part.x() / size, part.y() / size, part.width() / size, part.height() / size)
        )
        painter.setOpacity(1.0)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        zoom = placed.width() / max(self._crop.width(), 1e-9)
        onto = QTransform(zoom, 0, 0, zoom, placed.x() - zoom * self._crop.x(), placed.y() - zoom * self._crop.y())
        paths = [(_color(contour), onto.map(_path(contour))) for contour in contours]
        for _, path in paths:
            painter.strokePath(path, QPen(QColor(theme.HALO), _HALO))
        for color, path in paths:
            painter.strokePath(path, QPen(QColor(color), _LINE))
        painter.restore()


def _color(contour: Contour) -> str:
    return contour.color or look().color(theme.CLOSED if contour.closed else theme.OPEN)


def _path(contour: Contour) -> QPainterPath:
    made: QPainterPath = pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(contour.path)))
    return made
