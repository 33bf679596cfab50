"""The layer of the contours: closed and open ones in two colours, and the junctions where contours meet."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QPainter, QPainterPath
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from app.views import theme
from app.views.coordinates import image_rectangle, to_xy
from app.views.layers import cached, line_pen
from cpm_core.contour import Contour

Array = NDArray[np.float64]

_WIDTH = 2.0
_HALO_WIDTH = 3.6
_RIM = 4.0
_PIECE = 64


class ContourLayer:
    """Shows contours."""

    def __init__(self, view: pg.ViewBox) -> None:
        self._curves = {True: Curves(theme.CLOSED, 4.0), False: Curves(theme.OPEN, 4.1)}
        self._junctions = pg.ScatterPlotItem(
            size=8.0, symbol="d", pen=pg.mkPen(theme.HALO), brush=pg.mkBrush(theme.JUNCTION)
        )
        self._junctions.setZValue(5.5)
        for item in (*self._curves.values(), self._junctions):
            view.addItem(item, ignoreBounds=True)

    @property
    def counts(self) -> tuple[int, int]:
        """Closed and open contours shown."""
        return self._curves[True].count, self._curves[False].count

    def use_shape(self, shape: tuple[int, ...]) -> None:
        """Make room for an image of this shape."""
        for item in self._curves.values():
            item.use_shape(shape)

    def show(self, contours: Iterable[Contour]) -> None:
        """Show contours."""
        contours = tuple(contours)
        for closed, item in self._curves.items():
            item.show([contour.path for contour in contours if contour.closed == closed])
        ends = [contour.points[end] for contour in contours for end in (0, -1) if contour.junctions[end]]
        x, y = to_xy(np.unique(np.array(ends, dtype=float).reshape(-1, 2), axis=0))
        self._junctions.setData(x=x, y=y)

    def set_visible(self, visible: bool) -> None:
        """Show or hide them all."""
        for item in (*self._curves.values(), self._junctions):
            item.setVisible(visible)


class Curves(pg.GraphicsObject):  # type: ignore[misc]  # pyqtgraph has no type hints
    """Curves of one colour with a dark halo.

    Each is drawn in pieces of its own: the time that Qt takes for a wide line grows much faster than its length.

    Parameters
    ----------
    colour : str
        Colour.
    z : float
        Place in the pile of layers.
    """

    def __init__(self, colour: str, z: float) -> None:
        super().__init__()
        self._pens = (line_pen(theme.HALO, _HALO_WIDTH), line_pen(colour, _WIDTH))
        self._room = QRectF()
        self._pieces: list[QPainterPath] = []
        self.count = 0
        self.setZValue(z)
        cached(self)

    def use_shape(self, shape: tuple[int, ...]) -> None:
        """Make room for an image of this shape."""
        self.prepareGeometryChange()
        self._room = image_rectangle(shape).adjusted(-_RIM, -_RIM, _RIM, _RIM)

    def show(self, paths: list[Array]) -> None:
        """Show curves, each of shape (K, 2)."""
        if paths or self.count:
            self.count = len(paths)
            self._pieces = [pg.arrayToQPath(*to_xy(piece)) for path in paths for piece in pieces(path)]
            self.update()

    def boundingRect(self) -> QRectF:
        """Room that may be drawn on."""
        return self._room

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the halos, then the curves."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setBrush(QColor(0, 0, 0, 0))
        for pen in self._pens:
            painter.setPen(pen)
            for piece in self._pieces:
                painter.drawPath(piece)


def pieces(path: Array) -> Iterator[Array]:
    """Pieces of a path that overlap by a segment, so that no joint is left open."""
    for begin in range(0, max(len(path) - 1, 1), _PIECE):
        yield np.ascontiguousarray(path[max(begin - 1, 0) : begin + _PIECE + 1])
