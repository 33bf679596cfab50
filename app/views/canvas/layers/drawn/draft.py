"""The draft: what is being drawn and is not part of the document yet."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Qt

from app.views.canvas.coordinates import to_xy
from app.views.canvas.items.item import Markers, line_pen
from app.views.theme import theme
from cpm_core.numerics.types import Array, Position

_Z = 8.0


class Draft:
    """A path with its corners, the closing segment of a closed path, and the ring of a tool."""

    def __init__(self, view: pg.ViewBox) -> None:
        self._halo = pg.PlotCurveItem(antialias=True)
        self._path = pg.PlotCurveItem(antialias=True)
        self._closing = pg.PlotCurveItem(antialias=True)
        self._corners = Markers(size=6.0, symbol="s", pen=pg.mkPen(theme.HALO), brush=pg.mkBrush("w"))
        self._ring = pg.PlotCurveItem(antialias=True)
        self._rim = pg.PlotCurveItem(antialias=True)
        for index, item in enumerate((self._halo, self._path, self._closing, self._corners, self._rim, self._ring)):
            item.setZValue(_Z + 0.1 * index)
            view.addItem(item, ignoreBounds=True)

    def show(self, corners: tuple[Position, ...], path: tuple[Position, ...], color: str, closed: bool) -> None:
        """Show a path with corners, all (row, col)."""
        line = np.array(path, dtype=float).reshape(-1, 2)
        self._halo.setPen(line_pen(theme.HALO, 4.0, "shapes"))
        self._path.setPen(line_pen(color, 2.0, "shapes"))
        dashed = line_pen(color, 1.4, "shapes")
        dashed.setStyle(Qt.PenStyle.DashLine)
        self._closing.setPen(dashed)
        self._halo.setData(*to_xy(line))
        self._path.setData(*to_xy(line))
        self._closing.setData(*to_xy(line[[-1, 0]] if closed and len(line) > 2 else line[:0]))
        x, y = to_xy(np.array(corners, dtype=float).reshape(-1, 2))
        self._corners.setData(x=x, y=y)

    def show_ring(self, rim: Array, color: str) -> None:
        """Show the ring of a tool, shape (K, 2); an empty one hides it."""
        self._rim.setPen(line_pen(theme.HALO, 3.4, "shapes"))
        self._ring.setPen(line_pen(color, 1.6, "shapes"))
        for item in (self._rim, self._ring):
            item.setData(*to_xy(rim))
