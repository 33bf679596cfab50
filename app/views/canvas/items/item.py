"""What items on the canvas have in common: the room over an image, pens and caching."""

from __future__ import annotations

from typing import Any

import pyqtgraph as pg
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QPen
from PySide6.QtWidgets import QGraphicsItem

from app.views.canvas.coordinates import image_rectangle


def line_pen(color: str, width: float) -> QPen:
    """A pen whose width does not change with the zoom."""
    pen = QPen(QColor(color), width)
    pen.setCosmetic(True)
    return pen


def cached(item: QGraphicsItem) -> None:
    """Keep what an item looks like until it changes, for what lies above it changes much more often."""
    item.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)


class OverImage(pg.GraphicsObject):  # type: ignore[misc]  # pyqtgraph has no type hints
    """An item as large as the image and a rim around it.

    Parameters
    ----------
    z : float
        Place in the pile of layers.
    rim : float
        Width of the rim unless another is asked for [px of the image].
    """

    def __init__(self, z: float, rim: float) -> None:
        super().__init__()
        self._room = QRectF()
        self._rim = rim
        self.setZValue(z)

    def use_shape(self, shape: tuple[int, ...], rim: float | None = None) -> None:
        """Make room for an image of this shape and, all around, for a rim of so many px of the image."""
        width = self._rim if rim is None else rim
        self.prepareGeometryChange()
        self._room = image_rectangle(shape).adjusted(-width, -width, width, width)

    def boundingRect(self) -> QRectF:
        """Room that may be drawn on."""
        return self._room


class Markers(pg.ScatterPlotItem):  # type: ignore[misc]  # pyqtgraph has no type hints
    """Symbols of one size, few of them, that cost nothing in a frame where nothing is shown."""

    def paint(self, painter: Any, *rest: Any) -> None:
        """Draw the markers, if there are any."""
        if len(self.data):
            super().paint(painter, *rest)
