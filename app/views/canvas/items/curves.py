"""Curves and filled areas on the canvas, cached until they change."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from operator import itemgetter

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPainterPath
from PySide6.QtWidgets import QStyleOptionGraphicsItem, QWidget

from app.views.canvas.items.item import OverImage, cached, line_pen, to_xy
from app.views.theme import theme
from app.views.theme.theme import Kind, look
from cpm_core.numerics import Array, coarser

_RIM = 4.0
_PIECE = 64
_UNSEEN = 0.1
"""Distance from a line below which a corner is invisible [px of the screen]."""

_STEPS = 2
"""Zooms per factor of two at which invisible corners are removed again; in between slightly more is drawn."""

_WIDEST = 24.0
"""Margin for the widest line next to its corners [px of the screen]."""

_MANY = 100
"""Number of visible pieces from which halos are drawn without antialiasing."""

_DASHES = (2.5, 1.8)


class Curves(OverImage):
    """Curves with a dark halo.

    Each is drawn in pieces: the time that Qt takes for a wide line grows much faster than its length.

    Parameters
    ----------
    color : str
        Color of those that have none of their own.
    z : float
        Place in the stack of layers.
    width, halo : float
        Widths of the line and of its halo, 0 for no halo [px of the screen].
    dashed : bool or tuple of float
        Whether the line is dashed, or the lengths of dashes and gaps, in widths of the line.
    kind : {"contours", "shapes", "fixed"}
        What it belongs to; its width is as preferred for this kind.
    """

    count = 0

    def __init__(
        self,
        color: str,
        z: float,
        width: float = 2.0,
        halo: float = 3.6,
        dashed: bool | tuple[float, float] = False,
        kind: Kind = "contours",
    ) -> None:
        super().__init__(z, _RIM)
        self._color, self._width, self._kind = color, width, kind
        self._dashes = _DASHES if dashed is True else dashed or ()
        self._rim_of_halo = halo - width if halo else 0.0
        self._paths: Sequence[Array] = ()
        self.colors: Sequence[str] = ()
        """Color of each curve."""
        self._pieces: list[tuple[QPainterPath, str]] = []
        self._boxes = boxes([])
        self._made_for = 0.0
        cached(self)

    def show(self, paths: Sequence[Array], colors: Sequence[str] = ()) -> None:
        """Show curves, each of shape (K, 2), in colors of their own or in that of all."""
        if paths or self.count:
            self._paths, self.colors, self._made_for = paths, colors or (self._color,) * len(paths), 0.0
            self.renew(len(paths))

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the halos, then the curves."""
        painter.setBrush(QColor(0, 0, 0, 0))
        zoom = abs(painter.worldTransform().m11()) * painter.device().devicePixelRatioF()
        self._make_pieces(2.0 ** (math.ceil(_STEPS * math.log2(zoom)) / _STEPS))
        seen = [self._pieces[index] for index in self._visible(painter, zoom)]
        if self._rim_of_halo:
            # Where there are many halos, jagged ones are not visible below the smooth lines.
            painter.setRenderHint(QPainter.RenderHint.Antialiasing, len(seen) < _MANY)
            # The rim of a halo is as wide next to a line of any width.
            painter.setPen(line_pen(theme.HALO, self._width * look().width(self._kind) + self._rim_of_halo))
            for path, _ in seen:
                painter.drawPath(path)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        pens = {color: line_pen(color, self._width, self._kind) for color in set(self.colors)}
        for pen in pens.values() if self._dashes else ():
            pen.setDashPattern(self._dashes)
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
        for color, alike in groupby(seen, itemgetter(1)):
            painter.setPen(pens[color])
            for path, _ in alike:
                painter.drawPath(path)

    def _make_pieces(self, zoom: float) -> None:
        """Make the pieces for `zoom` px of the screen per px of the image, without corners that are invisible there."""
        if self._made_for != zoom:
            self._made_for = zoom
            paths = zip(coarser(self._paths, _UNSEEN / zoom), self.colors, strict=False)
            seen = [(piece, color) for path, color in paths for piece in pieces(path)]
            self._pieces = [(pg.arrayToQPath(*to_xy(piece)), color) for piece, color in seen]
            self._boxes = boxes([piece for piece, _ in seen])

    def _visible(self, painter: QPainter, zoom: float) -> list[int]:
        """Indices of the visible pieces; the others would take the painter as long."""
        device, (inverse, _) = painter.device(), painter.worldTransform().inverted()
        seen, rim = inverse.mapRect(QRectF(0.0, 0.0, device.width(), device.height())), _WIDEST / zoom
        (top, left), (bottom, right) = self._boxes
        rows = (bottom >= seen.top() - rim) & (top <= seen.bottom() + rim)
        return np.flatnonzero(rows & (right >= seen.left() - rim) & (left <= seen.right() + rim)).tolist()


def pieces(path: Array) -> Iterator[Array]:
    """Pieces of a path that overlap by a segment, so that no joint stays open."""
    for begin in range(0, max(len(path) - 1, 1), _PIECE):
        yield np.ascontiguousarray(path[max(begin - 1, 0) : begin + _PIECE + 1])


def boxes(paths: Sequence[Array]) -> tuple[Array, Array]:
    """Upper left and lower right corners of the boxes around paths, each (row, col), shape (2, P)."""
    if not paths:
        return np.empty((2, 0)), np.empty((2, 0))
    corners = np.concatenate(paths)
    first = np.concatenate([[0], np.cumsum([len(path) for path in paths])[:-1]])
    return np.minimum.reduceat(corners, first).T, np.maximum.reduceat(corners, first).T


_FILL_RIM = 4.0

Area = tuple[Sequence[Array], str, float]
"""Closed curves, each of shape (K, 2), with color and opacity; a place is inside if an odd number encloses it."""


class Fills(OverImage):
    """Translucent or hatched areas with holes; `z` is the place in the stack of layers."""

    count = 0

    def __init__(self, z: float, pattern: Qt.BrushStyle = Qt.BrushStyle.SolidPattern) -> None:
        super().__init__(z, _FILL_RIM)
        self._pattern = pattern
        self._areas: list[tuple[QPainterPath, str, float]] = []
        cached(self)

    def show(self, areas: Sequence[Area]) -> None:
        """Show areas, in the order in which they lie over each other."""
        if areas or self._areas:
            self._areas = []
            for curves, color, opacity in areas:
                path = QPainterPath()  # of which an odd number of curves encloses what is inside
                for curve in curves:
                    closed = np.concatenate([curve, curve[:1]])
                    path.addPath(pg.arrayToQPath(*map(np.ascontiguousarray, to_xy(closed))))
                self._areas.append((path, color, opacity))
            self.renew(len(areas))

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the areas."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for path, color, opacity in self._areas:
            tint = QColor(look().color(color))
            tint.setAlphaF(opacity)
            brush = QBrush(tint, self._pattern)
            brush.setTransform(painter.worldTransform().inverted()[0])  # a hatch is as dense at any zoom
            painter.fillPath(path, brush)
