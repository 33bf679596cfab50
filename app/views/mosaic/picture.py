"""Part of an image with its contours, as a picture of any size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPainterPath, QPen, QTransform

from app.model.display.display_image import DisplayImage
from app.views.canvas.coordinates import to_xy
from app.views.theme import theme
from cpm_core.contours.contour import Contour

_LINE, _HALO = 1.8, 3.2


class Picture:
    """Draws an image and contours into rectangles.

    Parameters
    ----------
    shades : ndarray of uint8, shape (H, W) or (H, W, 3)
        The image.
    crop : QRectF
        The part of it that is shown, in px of the image.
    """

    def __init__(self, shades: DisplayImage, crop: QRectF) -> None:
        gray = np.ascontiguousarray(shades)
        rows, cols = gray.shape[:2]
        kind = QImage.Format.Format_Grayscale8 if gray.ndim == 2 else QImage.Format.Format_RGB888
        self._image = QImage(gray.data, cols, rows, gray.strides[0], kind).copy()
        self._crop = crop

    def placed_in(self, room: QRectF) -> QRectF:
        """The largest rectangle of the right shape in the middle of some room."""
        size = QSizeF(self._crop.size()).scaled(room.size(), Qt.AspectRatioMode.KeepAspectRatio)
        placed = QRectF(room.topLeft(), size)
        placed.moveCenter(room.center())
        return placed

    def draw(self, painter: QPainter, room: QRectF, contours: Sequence[Contour] = (), pale: bool = False) -> None:
        """Draw it as large as there is room for; pale for what is still being worked on."""
        placed = self.placed_in(room)
        painter.save()
        painter.setClipRect(placed)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        painter.setOpacity(0.35 if pale else 1.0)
        # The first pixel of an image is drawn around (0, 0), as on the canvas.
        painter.drawImage(placed, self._image, self._crop.translated(0.5, 0.5))
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
    return contour.color or (theme.CLOSED if contour.closed else theme.OPEN)


def _path(contour: Contour) -> QPainterPath:
    made: QPainterPath = pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(contour.path)))
    return made
