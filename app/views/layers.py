"""The layers of the canvas, from the image below to the drawing on top; each redraws only what it is given."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QPen
from PySide6.QtWidgets import QGraphicsItem

from app.model.shades import Shades
from app.views import theme
from app.views.coordinates import image_rectangle, to_xy

Array = NDArray[np.float64]

ARROW_SPACING = 22.0
"""Least distance between two arrows of the field [px of the screen]."""


def line_pen(colour: str, width: float) -> QPen:
    """A pen whose width does not change with the zoom."""
    pen = QPen(QColor(colour), width)
    pen.setCosmetic(True)
    return pen


def cached(item: QGraphicsItem) -> None:
    """Keep what an item looks like until it changes, for what lies above it changes much more often."""
    item.setCacheMode(QGraphicsItem.CacheMode.DeviceCoordinateCache)


class ImageLayer:
    """The grey values."""

    def __init__(self, view: pg.ViewBox) -> None:
        self._item = pg.ImageItem()
        self._item.setZValue(0)
        cached(self._item)
        view.addItem(self._item, ignoreBounds=True)

    def show(self, shades: Shades) -> None:
        """Show an image."""
        self._item.setImage(shades, levels=(0, 255), rect=image_rectangle(shades.shape))


class EdgeMapLayer:
    """The edge map, half transparent and fully so where there is no edge."""

    def __init__(self, view: pg.ViewBox) -> None:
        self._item = pg.ImageItem()
        self._item.setZValue(1)
        cached(self._item)
        view.addItem(self._item, ignoreBounds=True)
        table = pg.colormap.get("inferno").getLookupTable(nPts=256, alpha=True)
        table[:, 3] = np.linspace(0, 235, 256).astype(np.uint8)
        self._item.setLookupTable(table)

    def show(self, shades: Shades | None) -> None:
        """Show an edge map, or nothing."""
        # hidden, not cleared: what is cached of an item would stay on screen when its extent vanishes
        self._item.setVisible(shades is not None)
        if shades is not None:
            self._item.setImage(shades, levels=(0, 255), rect=image_rectangle(shades.shape))


class FieldLayer:
    """Arrows along the Lorentz force, as many as the zoom leaves room for."""

    def __init__(self, view: pg.ViewBox) -> None:
        self._view = view
        self._item = pg.PlotCurveItem(pen=line_pen(theme.FIELD, 1.0), antialias=True)
        self._item.setZValue(2)
        cached(self._item)
        view.addItem(self._item, ignoreBounds=True)
        self._field: Array | None = None
        view.sigRangeChanged.connect(self._draw)

    def show(self, field: Array | None) -> None:
        """Show a field, shape (2, H, W), or nothing."""
        self._field = field
        self._draw()

    def _draw(self) -> None:
        self._item.setVisible(self._field is not None)
        if self._field is None:
            return
        starts, ends = arrows(self._field, self._view.viewRect(), self._view.viewPixelSize()[0])
        lines = arrow_lines(starts, ends)
        x, y = to_xy(lines)
        self._item.setData(x, y, connect="pairs")


def arrows(field: Array, seen: QRectF, pixel: float) -> tuple[Array, Array]:
    """Where arrows begin and end so that they neither crowd nor lie outside what is seen.

    Parameters
    ----------
    field : ndarray, shape (2, H, W)
        Vectors of at most unit length.
    seen : QRectF
        Part of the canvas that is seen.
    pixel : float
        Size of a pixel of the screen [px of the image].

    Returns
    -------
    starts, ends : ndarray, shape (N, 2)
        (row, col).
    """
    stride = max(1, int(np.ceil(ARROW_SPACING * pixel)))
    rows = np.arange(stride // 2, field.shape[1], stride)
    cols = np.arange(stride // 2, field.shape[2], stride)
    rows = rows[(rows >= seen.top()) & (rows <= seen.bottom())]
    cols = cols[(cols >= seen.left()) & (cols <= seen.right())]
    grid = np.stack(np.meshgrid(rows, cols, indexing="ij"), axis=-1).reshape(-1, 2)
    vectors = field[:, grid[:, 0], grid[:, 1]].T * (0.85 * stride)
    starts = grid - 0.5 * vectors
    return starts, starts + vectors


def arrow_lines(starts: Array, ends: Array) -> Array:
    """Pairs of points, shape (6 N, 2), that draw a shaft and two barbs for each arrow."""
    vectors = ends - starts
    across = np.stack([vectors[:, 1], -vectors[:, 0]], axis=1)
    left = ends - 0.30 * vectors + 0.18 * across
    right = ends - 0.30 * vectors - 0.18 * across
    return np.stack([starts, ends, left, ends, right, ends], axis=1).reshape(-1, 2)
