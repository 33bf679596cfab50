"""Curves and filled areas on the canvas, cached until they change."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Hashable, Iterator, Sequence
from itertools import groupby, islice
from operator import itemgetter

import numpy as np
from pyqtgraph.functions import create_qpolygonf, ndarray_from_qpolygonf
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QBrush, QColor, QPainter, QPainterPath, QPolygonF
from PySide6.QtWidgets import QGraphicsItem, QStyleOptionGraphicsItem, QWidget

from cpm_app.views.items.item import OverImage, cached, line_pen
from cpm_app.views.theme import theme
from cpm_app.views.theme.theme import Kind, look
from cpm_app.views.widgets.turns import Turns
from cpm_core.numerics import Array, Mask, coarser

_RIM = 4.0
_PIECE = 64
_UNSEEN = 0.1
"""Distance from a line below which a corner is invisible [px of the screen]."""

_STEPS = 2
"""Zooms per factor of two at which invisible corners are removed again; in between slightly more is drawn."""

_AT_ONCE = 3000
"""Most corners that are drawn in a turn of the event loop, unless a single curve has more."""

_DASHES = (2.5, 1.8)


class Parts(OverImage):
    """An item of many parts, cached: those that have changed are drawn again, many of them in several turns."""

    count = 0
    beyond = 2.0
    """How far they are drawn beyond their corners [px of the screen]."""

    def __init__(self, z: float) -> None:
        super().__init__(z, _RIM)
        self._keys: list[Hashable] = []
        self._boxes, self._corners = boxes([]), np.empty(0, int)
        self._changed = boxes([])
        """Where something is drawn that is not there any more, or is not drawn yet."""
        self._waiting: set[Hashable] = set()
        """Keys of what is not drawn yet."""
        cached(self)
        self.setFlag(QGraphicsItem.GraphicsItemFlag.ItemUsesExtendedStyleOption)

    def use(self, keys: list[Hashable], paths: Sequence[Array]) -> None:
        """Use parts, each with the corners of a box around it; those of equal keys are drawn alike."""
        same = {*self._keys} & {*keys}
        if [key for key in self._keys if key in same] != [key for key in keys if key in same]:
            same = set()  # others lie on top
        gone = self._boxes[:, [key not in same for key in self._keys]]
        self._waiting = {*keys} - (same - self._waiting)
        self._keys, self._boxes, self._corners = keys, boxes(paths), np.array([len(path) for path in paths], int)
        new = self._boxes[:, [key in self._waiting for key in keys]]
        self._changed = np.unique(np.concatenate([self._changed, gone, new], axis=1), axis=1)
        self.count = len(keys)
        self.setVisible(self._shown)
        self._draw(self._changed.shape[1] if self._fits(self._changed) else 0)

    def draw_next(self) -> None:
        """Draw what has changed from the top on, as much as a turn has time for."""
        most = self._changed.shape[1]
        fitting = bisect_left(range(1, most + 1), 1, key=lambda end: not self._fits(self._changed[:, :end]))
        self._draw(max(fitting, min(most, 1)))

    def _fits(self, changed: Array) -> bool:
        """Whether a turn has time for all that lies where something has changed."""
        return not changed.size or self._corners[meeting(self._boxes, around(changed))].sum() <= _AT_ONCE

    def _draw(self, count: int) -> None:
        """Draw again where so many have changed, and the others in later turns."""
        if count:
            top, left, bottom, right = area = around(self._changed[:, :count])
            self._waiting -= {self._keys[index] for index in np.flatnonzero(inside(self._boxes, area))}
            self._changed = self._changed[:, ~inside(self._changed, area)]
            rim = self.beyond / max(abs(self.sceneTransform().m11()), 1e-9)
            self.update(QRectF(left, top, right - left, bottom - top).adjusted(-rim, -rim, rim, rim))
        if self._changed.size:
            turns = self.scene().findChild(Turns) or Turns(self.scene())
            turns.ask(self.draw_next)

    def seen(self, painter: QPainter, option: QStyleOptionGraphicsItem) -> tuple[list[int], Array]:
        """Indices of the parts that are to be drawn, and the box of the place where they are."""
        device, (inverse, _) = painter.device(), painter.worldTransform().inverted()
        room = inverse.mapRect(QRectF(0.0, 0.0, device.width(), device.height())).intersected(option.exposedRect)
        rim = self.beyond / abs(painter.worldTransform().m11())
        place = np.array([room.top() - rim, room.left() - rim, room.bottom() + rim, room.right() + rim])
        found = np.flatnonzero(meeting(self._boxes, place)).tolist()
        return [index for index in found if self._keys[index] not in self._waiting], place


class Curves(Parts):
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

    def __init__(
        self,
        color: str,
        z: float,
        width: float = 2.0,
        halo: float = 3.6,
        dashed: bool | tuple[float, float] = False,
        kind: Kind = "contours",
    ) -> None:
        super().__init__(z)
        self._color, self._width, self._kind = color, width, kind
        self._dashes = _DASHES if dashed is True else dashed or ()
        self._rim_of_halo = halo - width if halo else 0.0
        self._paths: Sequence[Array] = ()
        self.colors: Sequence[str] = ()
        """Color of each curve."""
        self._pieces: dict[Hashable, list[tuple[Array, QPolygonF]]] = {}
        """Pieces of those that have been drawn, with their boxes."""
        self._made_for = 0.0

    @property
    def beyond(self) -> float:  # type: ignore[override]  # the width is a preference
        """How far lines and halos are drawn next to their corners, with their caps [px of the screen]."""
        return 2.0 + self._width * look().width(self._kind) + self._rim_of_halo

    def show(self, paths: Sequence[Array], colors: Sequence[str] = ()) -> None:
        """Show curves, each of shape (K, 2), in colors of their own or in that of all."""
        if paths or self.count:
            colors = colors or (self._color,) * len(paths)
            keys: list[Hashable] = [(id(path), color) for path, color in zip(paths, colors, strict=True)]
            self.use(keys, paths)
            self._paths, self.colors = paths, colors  # those before stay until here, so that no other one has their ids
            self._pieces = {key: self._pieces[key] for key in keys if key in self._pieces}

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the halos, then the curves."""
        painter.setBrush(QColor(0, 0, 0, 0))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        zoom = abs(painter.worldTransform().m11()) * painter.device().devicePixelRatioF()
        indices, place = self.seen(painter, option)
        self._make_pieces(indices, 2.0 ** (math.ceil(_STEPS * math.log2(zoom)) / _STEPS))
        near = [(piece, self.colors[index]) for index in indices for piece in self._pieces[self._keys[index]]]
        visible = meeting(np.array([box for (box, _), _ in near]).reshape(-1, 4).T, place)
        seen = [(line, color) for ((_, line), color), is_seen in zip(near, visible.tolist(), strict=True) if is_seen]
        if self._rim_of_halo:
            # The rim of a halo is as wide next to a line of any width.
            painter.setPen(line_pen(theme.HALO, self._width * look().width(self._kind) + self._rim_of_halo))
            for line, _ in seen:
                painter.drawPolyline(line)
        pens = {color: line_pen(color, self._width, self._kind) for color in set(self.colors)}
        for pen in pens.values() if self._dashes else ():
            pen.setDashPattern(self._dashes)
            pen.setCapStyle(Qt.PenCapStyle.FlatCap)
        for color, alike in groupby(seen, itemgetter(1)):
            painter.setPen(pens[color])
            for line, _ in alike:
                painter.drawPolyline(line)

    def _make_pieces(self, indices: list[int], zoom: float) -> None:
        """Make the pieces for `zoom` px of the screen per px of the image, without corners that are invisible there."""
        if self._made_for != zoom:
            self._made_for, self._pieces = zoom, {}
        missing = [index for index in indices if self._keys[index] not in self._pieces]
        lines = [[*pieces(path)] for path in coarser([self._paths[index] for index in missing], _UNSEEN / zoom)]
        each = [line for own in lines for line in own]
        made = zip(boxes(each).T, map(_polygon, each), strict=True)
        for index, own in zip(missing, lines, strict=True):
            self._pieces[self._keys[index]] = [*islice(made, len(own))]


def _polygon(path: Array) -> QPolygonF:
    """A path, shape (K, 2), for a painter."""
    polygon = create_qpolygonf(len(path))
    ndarray_from_qpolygonf(polygon)[:] = path[:, ::-1]
    return polygon


def pieces(path: Array) -> Iterator[Array]:
    """Pieces of a path that overlap by a segment, so that no joint stays open."""
    for begin in range(0, max(len(path) - 1, 1), _PIECE):
        yield path[max(begin - 1, 0) : begin + _PIECE + 1]


def boxes(paths: Sequence[Array]) -> Array:
    """Top, left, bottom and right of the boxes around paths, shape (4, P)."""
    if not paths:
        return np.empty((4, 0))
    corners = np.concatenate(paths)
    first = np.concatenate([[0], np.cumsum([len(path) for path in paths])[:-1]])
    return np.hstack([np.minimum.reduceat(corners, first), np.maximum.reduceat(corners, first)]).T


def around(areas: Array) -> Array:
    """The box around boxes, shape (4, N)."""
    return np.concatenate([areas[:2].min(axis=1), areas[2:].max(axis=1)])


def meeting(areas: Array, area: Array) -> Mask:
    """Which boxes, shape (4, N), have a place in common with one, shape (4,)."""
    return np.logical_and.reduce([*(areas[:2] <= area[2:, None]), *(areas[2:] >= area[:2, None])])


def inside(areas: Array, area: Array) -> Mask:
    """Which boxes, shape (4, N), lie in one, shape (4,)."""
    return np.logical_and.reduce([*(areas[:2] >= area[:2, None]), *(areas[2:] <= area[2:, None])])


Area = tuple[Sequence[Array], str, float]
"""Closed curves, each of shape (K, 2), with color and opacity; a place is inside if an odd number encloses it."""


class Fills(Parts):
    """Translucent or hatched areas with holes; `z` is the place in the stack of layers."""

    def __init__(self, z: float, pattern: Qt.BrushStyle = Qt.BrushStyle.SolidPattern) -> None:
        super().__init__(z)
        self._pattern = pattern
        self._areas: Sequence[Area] = ()
        self._paths: dict[Hashable, QPainterPath] = {}

    def show(self, areas: Sequence[Area]) -> None:
        """Show areas, in the order in which they lie over each other."""
        if areas or self.count:
            keys: list[Hashable] = [(*map(id, curves), color, opacity) for curves, color, opacity in areas]
            self.use(keys, [np.concatenate(curves) for curves, *_ in areas])
            self._areas = areas  # those before stay until here, so that no other one has their ids
            self._paths = {key: self._paths[key] for key in keys if key in self._paths}

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the areas."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        inverse = painter.worldTransform().inverted()[0]
        for index in self.seen(painter, option)[0]:
            key, (curves, color, opacity) = self._keys[index], self._areas[index]
            if key not in self._paths:
                self._paths[key] = path = QPainterPath()  # of which an odd number of curves encloses what is inside
                for curve in curves:
                    path.addPolygon(_polygon(curve))
            tint = QColor(look().color(color))
            tint.setAlphaF(opacity)
            brush = QBrush(tint, self._pattern)
            brush.setTransform(inverse)  # a hatch is as dense at any zoom
            painter.fillPath(self._paths[key], brush)
