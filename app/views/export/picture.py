"""The preview of an export: the image with what the files will hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QColor, QImage, QPainter, QPen, QPixmap, QResizeEvent, QTransform
from PySide6.QtWidgets import QLabel

from app.model.display.display_image import DisplayImage
from app.model.text.language import tr
from app.views.canvas.items.item import to_xy
from app.views.theme import theme
from app.views.theme.theme import look
from cpm_core import Contour

_LINE, _FILL = 1.7, 100
"""Width of lines [px of the screen], and opacity of objects, of 255."""

_LONGEST = 1000.0
"""Pixels along the longer side of the image that is drawn."""


@dataclass(frozen=True, slots=True)
class Line:
    """A contour and how it is drawn: filled in its color, or pale and dashed where no file holds it."""

    contour: Contour
    filled: bool = False
    pale: bool = False


class Preview(QLabel):
    """What the files will hold on the image, and, pale, what they will not."""

    def __init__(self, display: DisplayImage) -> None:
        super().__init__()
        gray = np.ascontiguousarray(display.reduced(_LONGEST))
        rows, cols = gray.shape[:2]
        kind = QImage.Format.Format_Grayscale8 if gray.ndim == 2 else QImage.Format.Format_RGB888
        self._image = QImage(gray.data, cols, rows, gray.strides[0], kind).copy()
        self._width = display.shape[1]
        self._lines: Sequence[Line] = ()
        self.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.setMinimumSize(240, 200)
        self.setAccessibleName(tr("Preview of the export"))

    def sizeHint(self) -> QSize:
        """Large enough to see single contours."""
        return QSize(460, 460)

    def show_lines(self, lines: Sequence[Line]) -> None:
        """Show lines on the image."""
        self._lines, ratio = lines, self.devicePixelRatioF()
        ways = Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation
        made = QPixmap.fromImage(self._image.scaled(self.size() * ratio, *ways))
        zoom = made.width() / self._width
        painter = QPainter(made)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        # The center of the first pixel of an image is (0, 0), as on the canvas.
        onto = QTransform(zoom, 0, 0, zoom, 0.5 * zoom, 0.5 * zoom)
        for line in lines:
            path = onto.map(pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(line.contour.path))))
            color = QColor(line.contour.color or look().color(theme.CONTOUR))
            if line.pale:
                painter.strokePath(path, QPen(QColor(look().color(theme.REJECTED)), ratio, Qt.PenStyle.DashLine))
                continue
            painter.strokePath(path, QPen(color, _LINE * ratio))
            if line.filled:
                color.setAlpha(_FILL)
                painter.fillPath(path, color)
        painter.end()
        made.setDevicePixelRatio(ratio)
        self.setPixmap(made)

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Draw the picture in its new size."""
        self.show_lines(self._lines)
