"""Common parts of items on the canvas: the area over an image, pens, caching and markers."""

from __future__ import annotations

from typing import Any

import pyqtgraph as pg
from pyqtgraph.Qt import QtWidgets
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QPen
from PySide6.QtWidgets import QGraphicsItem

from app.views.canvas.coordinates import image_rectangle
from app.views.theme.look import Kind, look


def line_pen(color: str, width: float, kind: Kind = "fixed") -> QPen:
    """A pen whose width does not change with the zoom; color and width are as preferred for this kind of line."""
    pen = QPen(QColor(look().color(color)), width * look().width(kind))
    pen.setCosmetic(True)
    return pen


def cached(item: QGraphicsItem) -> None:
    """Cache the rendered item until it changes: the items above it change much more often."""
    item.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)


class OverImage(QtWidgets.QGraphicsObject):  # type: ignore[misc]  # `show` of its kinds takes what they draw
    """An item that covers the image and a rim around it.

    It is an item of Qt: one of pyqtgraph follows each change of its view and of itself, which none of these needs.

    Parameters
    ----------
    z : float
        Place in the stack of layers.
    rim : float
        Default width of the rim [px of the image].
    """

    def __init__(self, z: float, rim: float) -> None:
        super().__init__()
        self._room = QRectF()
        self._rim = rim
        self._shown = True
        self.setZValue(z)

    def use_shape(self, shape: tuple[int, ...], rim: float | None = None) -> None:
        """Cover an image of this shape and a rim around it."""
        width = self._rim if rim is None else rim
        self.prepareGeometryChange()
        self._room = image_rectangle(shape).adjusted(-width, -width, width, width)

    @property
    def empty(self) -> bool:
        """Whether there is nothing to draw."""
        return False

    def set_shown(self, shown: bool) -> None:
        """Show or hide the item; an empty one is hidden and costs nothing in a frame."""
        self._shown = shown
        self.setVisible(shown and not self.empty)

    def boundingRect(self) -> QRectF:
        """The area that may be drawn on."""
        return self._room


class Markers(pg.ScatterPlotItem):  # type: ignore[misc]  # pyqtgraph has no type hints
    """A few symbols of one size; without symbols, painting costs nothing."""

    def paint(self, painter: Any, *rest: Any) -> None:
        """Draw the markers, if there are any."""
        if len(self.data):
            super().paint(painter, *rest)
