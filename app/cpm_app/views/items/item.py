"""Common parts of items on the canvas: coordinates, pens, caching, markers, labels, and pinned text."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from pyqtgraph.Qt import QtWidgets
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPen
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from cpm_app.views.theme import theme
from cpm_app.views.theme.theme import LineKind, get_canvas_style
from cpm_core.numerics import Array, Place, Position
from cpm_core.numerics.types import Extent


def to_xy(positions: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return x and y on the canvas, each of shape (N,), of positions (row, col), shape (N, 2)."""
    return positions[:, 1], positions[:, 0]


def to_position(point: QPointF) -> Position:
    """Return the position (row, col) of a point on the canvas."""
    return (point.y(), point.x())


def image_rectangle(shape: Extent) -> QRectF:
    """Return the rectangle of an image on the canvas; it begins half a pixel before the center of the first pixel."""
    rows, cols = shape
    return QRectF(-0.5, -0.5, cols, rows)


def line_pen(color: str, width: float, kind: LineKind = "fixed") -> QPen:
    """Create a pen of constant width at any zoom; the preferences scale its width and adapt its color."""
    pen = QPen(QColor(get_canvas_style().resolve_color(color)), width * get_canvas_style().width_factor(kind))
    pen.setCosmetic(True)
    return pen


def enable_caching(item: QGraphicsItem) -> None:
    """Cache the rendered item until it changes; the items above it change much more often."""
    item.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)


class ImageOverlay(QtWidgets.QGraphicsObject):  # type: ignore[misc]  # pyqtgraph has no type hints
    """An item that covers the image and a rim around it.

    It is a plain Qt item: a pyqtgraph item tracks every change of its view, which costs time and is not needed here.

    Parameters
    ----------
    z : float
        Place in the stack of layers.
    rim : float
        Default width of the rim [px of the image].
    """

    count = 1
    """Number of parts shown; without any, the item is hidden and costs nothing in a frame."""

    def __init__(self, z: float, rim: float) -> None:
        super().__init__()
        self._room = QRectF()
        self._rim = rim
        self.setZValue(z)
        self.setVisible(True)

    def set_image_shape(self, shape: Extent, rim: float | None = None) -> None:
        """Cover an image of this shape and a rim around it."""
        width = self._rim if rim is None else rim
        self.prepareGeometryChange()
        self._room = image_rectangle(shape).adjusted(-width, -width, width, width)

    def setVisible(self, shown: bool) -> None:
        """Show or hide the item."""
        self._shown = shown
        super().setVisible(shown and self.count > 0)

    def update_count(self, count: int) -> None:
        """Set the number of parts, and draw again."""
        self.count = count
        self.update()
        self.setVisible(self._shown)

    def boundingRect(self) -> QRectF:
        """Return the area that may be drawn on."""
        return self._room


class Markers(pg.ScatterPlotItem):  # type: ignore[misc]  # pyqtgraph has no type hints
    """A few symbols of one size; `z` is the place in the stack of layers, the rest is as in `pg.ScatterPlotItem`."""

    _shown = True

    def __init__(self, z: float, **look: Any) -> None:
        super().__init__(**look)
        self.setZValue(z)
        self.setVisible(True)

    def show_markers(self, positions: Collection[Place] | Array, **look: Any) -> None:
        """Show markers at positions (row, col), shape (N, 2) [px]; `get_canvas_style` overrides their appearance."""
        x, y = to_xy(np.array([*positions], dtype=float).reshape(-1, 2))
        self.setData(x=x, y=y, **look)
        self.setVisible(self._shown)

    def setVisible(self, shown: bool) -> None:
        """Show or hide the markers; without any, the item is hidden and costs nothing in a frame."""
        self._shown = shown
        super().setVisible(shown and len(self.data) > 0)


_NAME_PAD = 4.0
"""Padding of a text on its background [px of the screen]."""

_NAME_RIM = 300.0
"""Margin around the image for text beyond its border [px of the image]."""


class TextLabels(ImageOverlay):
    """Texts above positions of the image, at constant size for any zoom."""

    count = 0

    def __init__(self, z: float) -> None:
        super().__init__(z, _NAME_RIM)
        self.texts: Sequence[tuple[Position, str, str]] = ()

    def show_texts(self, texts: Sequence[tuple[Position, str, str]]) -> None:
        """Show texts, each given by position (row, col), text and color."""
        if texts or self.texts:
            self.texts = texts
            self.update_count(len(texts))

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw each text on a dark background."""
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
            width, height = metrics.horizontalAdvance(text) + 2 * _NAME_PAD, metrics.height() + _NAME_PAD
            top = at.y() - height - _NAME_PAD
            if at.y() >= 0.0:  # in view, as its text has to be
                top = max(top, 0.0)
            room = QRectF(at.x() - width / 2, top, width, height)
            background = QColor(theme.CANVAS_HALO_COLOR)
            background.setAlpha(205)
            painter.setPen(Qt.PenStyle.NoPen)
            painter.setBrush(background)
            painter.drawRoundedRect(room, 4.0, 4.0)
            painter.setPen(QColor(color))
            painter.drawText(room, Qt.AlignmentFlag.AlignCenter, text)
        painter.restore()


_PINNED_MARGIN = 12.0
"""Default distance of pinned text from the border of the canvas [px of the screen]."""

_TEXT_BACKGROUND = "#cc101216"
"""Color behind pinned text."""

TEXT_COLOR = "#f2f4f7"
"""Color of pinned text."""

FAINT_TEXT_COLOR = "#b6bec9"
"""Color of less important pinned text."""

_PINNED_Z = 20.0
"""Place in the stack, above everything else."""


class PinnedText(pg.TextItem):  # type: ignore[misc]  # pyqtgraph has no type hints
    """Text on a dark background near the edge of a view; it does not move with the image.

    Parameters
    ----------
    view : pg.ViewBox
        Parent of the text.
    edge : tuple of float
        Anchor in the text and in the view, as fractions of width and height.
    gap : float
        Distance from the border of the view [px of the screen].
    """

    def __init__(self, view: pg.ViewBox, edge: tuple[float, float], gap: float = _PINNED_MARGIN) -> None:
        super().__init__(color=TEXT_COLOR, fill=QColor(_TEXT_BACKGROUND), anchor=edge)
        self._view, self._edge, self._gap = view, edge, gap
        self.html = ""
        """Text that is shown."""
        self.setParentItem(view)
        self.setZValue(_PINNED_Z)
        self.setVisible(False)
        view.sigResized.connect(self._place_at_edge)
        self._place_at_edge()

    def show_html(self, html: str) -> None:
        """Show another text."""
        if html != self.html:
            self.html = html
            self.setHtml(html)
            self.textItem.setTextWidth(-1.0)
            self.setTextWidth(self.textItem.document().idealWidth())  # without a width nothing is centered

    def _place_at_edge(self, *_: object) -> None:
        room = self._view.boundingRect().adjusted(self._gap, self._gap, -self._gap, -self._gap)
        x, y = self._edge
        self.setPos(round(room.left() + x * room.width()), round(room.top() + y * room.height()))
