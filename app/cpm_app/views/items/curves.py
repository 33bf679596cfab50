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

from cpm_app.views.items.item import ImageOverlay, enable_caching, line_pen
from cpm_app.views.theme import theme
from cpm_app.views.theme.theme import LineKind, get_canvas_style
from cpm_app.views.widgets.turns import Turns
from cpm_core.numerics import Array, Mask, drop_flat_corners

_CURVE_RIM = 4.0
"""Margin around the image for curves on its border [px of the image]."""

_PIECE_SEGMENTS = 64
"""Number of segments of a piece of a curve."""

_MAX_UNSEEN_OFFSET = 0.1
"""Distance from a line below which a corner is invisible [px of the screen]."""

_ZOOMS_PER_DOUBLING = 2
"""Number of zooms per factor of two at which invisible corners are removed; in between, slightly more are drawn."""

_MAX_CORNERS_PER_TURN = 3000
"""Largest number of corners drawn in a turn of the event loop, unless a single curve has more."""

_DEFAULT_DASHES = (2.5, 1.8)
"""Default lengths of dashes and gaps [widths of the line]."""


class MultiPartItem(ImageOverlay):
    """A cached item of many parts: only changed parts are drawn again, over several turns if there are many."""

    count = 0
    overhang = 2.0
    """Distance that parts are drawn beyond their corners [px of the screen]."""

    def __init__(self, z: float) -> None:
        super().__init__(z, _CURVE_RIM)
        self._keys: list[Hashable] = []
        self._boxes, self._corners = bounding_boxes([]), np.empty(0, int)
        self._changed = bounding_boxes([])
        """Boxes to draw again: of parts that are gone, or not drawn yet, shape (4, N)."""
        self._waiting: set[Hashable] = set()
        """Keys of parts not drawn yet."""
        enable_caching(self)
        self.setFlag(QGraphicsItem.GraphicsItemFlag.ItemUsesExtendedStyleOption)

    def set_parts(self, keys: list[Hashable], paths: Sequence[Array]) -> None:
        """Set the parts, and draw the changed ones.

        Parameters
        ----------
        keys : list of hashable
            Keys of the parts; parts with equal keys look the same.
        paths : sequence of ndarray, shape (K, 2)
            Corners (row, col) of each part [px of the image].
        """
        same = {*self._keys} & {*keys}
        if [key for key in self._keys if key in same] != [key for key in keys if key in same]:
            same = set()  # the stacking order has changed
        gone = self._boxes[:, [key not in same for key in self._keys]]
        self._waiting = {*keys} - (same - self._waiting)
        self._keys, self._boxes, self._corners = (
            keys,
            bounding_boxes(paths),
            np.array([len(path) for path in paths], int),
        )
        new = self._boxes[:, [key in self._waiting for key in keys]]
        self._changed = np.unique(np.concatenate([self._changed, gone, new], axis=1), axis=1)
        self.count = len(keys)
        self.setVisible(self._shown)
        self._redraw_parts(self._changed.shape[1] if self._fits_in_turn(self._changed) else 0)

    def draw_next_parts(self) -> None:
        """Draw changed parts from the top down, as many as one turn of the event loop has time for."""
        most = self._changed.shape[1]
        fitting = bisect_left(range(1, most + 1), 1, key=lambda end: not self._fits_in_turn(self._changed[:, :end]))
        self._redraw_parts(max(fitting, min(most, 1)))

    def _fits_in_turn(self, changed: Array) -> bool:
        """Tell whether one turn has time for all parts in the changed boxes, shape (4, N)."""
        return (
            not changed.size
            or self._corners[find_overlapping(self._boxes, enclosing_box(changed))].sum() <= _MAX_CORNERS_PER_TURN
        )

    def _redraw_parts(self, count: int) -> None:
        """Draw the first `count` changed boxes now, and the others in later turns."""
        if count:
            top, left, bottom, right = area = enclosing_box(self._changed[:, :count])
            self._waiting -= {self._keys[index] for index in np.flatnonzero(find_contained(self._boxes, area))}
            self._changed = self._changed[:, ~find_contained(self._changed, area)]
            rim = self.overhang / max(abs(self.sceneTransform().m11()), 1e-9)
            self.update(QRectF(left, top, right - left, bottom - top).adjusted(-rim, -rim, rim, rim))
        if self._changed.size:
            turns = self.scene().findChild(Turns) or Turns(self.scene())
            turns.schedule_work(self.draw_next_parts)

    def find_visible_parts(self, painter: QPainter, option: QStyleOptionGraphicsItem) -> tuple[list[int], Array]:
        """Return the indices of the parts to draw, and the exposed box (top, left, bottom, right), shape (4,)."""
        device, (inverse, _) = painter.device(), painter.worldTransform().inverted()
        room = inverse.mapRect(QRectF(0.0, 0.0, device.width(), device.height())).intersected(option.exposedRect)
        rim = self.overhang / abs(painter.worldTransform().m11())
        place = np.array([room.top() - rim, room.left() - rim, room.bottom() + rim, room.right() + rim])
        found = np.flatnonzero(find_overlapping(self._boxes, place)).tolist()
        return [index for index in found if self._keys[index] not in self._waiting], place


class Curves(MultiPartItem):
    """Curves with a dark halo.

    Each is drawn in pieces, because the time that Qt takes for a wide line grows much faster than its length.

    Parameters
    ----------
    color : str
        Default color of the curves.
    z : float
        Place in the stack of layers.
    width, halo : float
        Widths of the line and of its halo, 0 for no halo [px of the screen].
    dashed : bool or tuple of float
        Whether the line is dashed, or the lengths of dashes and gaps, in widths of the line.
    kind : {"contours", "shapes", "fixed"}
        Kind of line, whose width is a preference.
    """

    def __init__(
        self,
        color: str,
        z: float,
        width: float = 2.0,
        halo: float = 3.6,
        dashed: bool | tuple[float, float] = False,
        kind: LineKind = "contours",
    ) -> None:
        super().__init__(z)
        self._color, self._width, self._kind = color, width, kind
        self._dashes = _DEFAULT_DASHES if dashed is True else dashed or ()
        self._rim_of_halo = halo - width if halo else 0.0
        self._paths: Sequence[Array] = ()
        self.colors: Sequence[str] = ()
        """Color of each curve."""
        self._pieces: dict[Hashable, list[tuple[Array, QPolygonF]]] = {}
        """Pieces of the drawn curves, with their boxes, by key."""
        self._made_for = 0.0

    @property
    def overhang(self) -> float:  # type: ignore[override]  # the width is a preference
        """Distance that lines, halos and caps reach beyond the corners [px of the screen]."""
        return 2.0 + self._width * get_canvas_style().width_factor(self._kind) + self._rim_of_halo

    def show_paths(self, paths: Sequence[Array], colors: Sequence[str] = ()) -> None:
        """Show curves, each of shape (K, 2), (row, col) [px], in the given colors or the default one."""
        if paths or self.count:
            colors = colors or (self._color,) * len(paths)
            keys: list[Hashable] = [(id(path), color) for path, color in zip(paths, colors, strict=True)]
            self.set_parts(keys, paths)
            self._paths, self.colors = paths, colors  # the old ones live until here, so that no new one reuses an id
            self._pieces = {key: self._pieces[key] for key in keys if key in self._pieces}

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the halos, then the curves."""
        painter.setBrush(QColor(0, 0, 0, 0))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        zoom = abs(painter.worldTransform().m11()) * painter.device().devicePixelRatioF()
        indices, place = self.find_visible_parts(painter, option)
        self._build_pieces(indices, 2.0 ** (math.ceil(_ZOOMS_PER_DOUBLING * math.log2(zoom)) / _ZOOMS_PER_DOUBLING))
        near = [(piece, self.colors[index]) for index in indices for piece in self._pieces[self._keys[index]]]
        visible = find_overlapping(np.array([box for (box, _), _ in near]).reshape(-1, 4).T, place)
        seen = [(line, color) for ((_, line), color), is_seen in zip(near, visible.tolist(), strict=True) if is_seen]
        if self._rim_of_halo:
            # The rim of the halo is equally wide next to lines of any width.
            painter.setPen(
                line_pen(
                    theme.CANVAS_HALO_COLOR,
                    self._width * get_canvas_style().width_factor(self._kind) + self._rim_of_halo,
                )
            )
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

    def _build_pieces(self, indices: list[int], zoom: float) -> None:
        """Build missing pieces without the corners invisible at `zoom` [px of the screen per px of the image]."""
        if self._made_for != zoom:
            self._made_for, self._pieces = zoom, {}
        missing = [index for index in indices if self._keys[index] not in self._pieces]
        lines = [
            [*split_into_pieces(path)]
            for path in drop_flat_corners([self._paths[index] for index in missing], _MAX_UNSEEN_OFFSET / zoom)
        ]
        each = [line for own in lines for line in own]
        made = zip(bounding_boxes(each).T, map(_build_polygon, each), strict=True)
        for index, own in zip(missing, lines, strict=True):
            self._pieces[self._keys[index]] = [*islice(made, len(own))]


def _build_polygon(path: Array) -> QPolygonF:
    """Convert a path (row, col), shape (K, 2), to a polygon for a painter."""
    polygon = create_qpolygonf(len(path))
    ndarray_from_qpolygonf(polygon)[:] = path[:, ::-1]
    return polygon


def split_into_pieces(path: Array) -> Iterator[Array]:
    """Split a path, shape (K, 2), into pieces that overlap by a segment, so that no joint stays open."""
    for begin in range(0, max(len(path) - 1, 1), _PIECE_SEGMENTS):
        yield path[max(begin - 1, 0) : begin + _PIECE_SEGMENTS + 1]


def bounding_boxes(paths: Sequence[Array]) -> Array:
    """Return the bounding boxes (top, left, bottom, right), shape (4, P), of P paths, each of shape (K, 2)."""
    if not paths:
        return np.empty((4, 0))
    corners = np.concatenate(paths)
    first = np.concatenate([[0], np.cumsum([len(path) for path in paths])[:-1]])
    return np.hstack([np.minimum.reduceat(corners, first), np.maximum.reduceat(corners, first)]).T


def enclosing_box(areas: Array) -> Array:
    """Return the box, shape (4,), that encloses boxes, shape (4, N)."""
    return np.concatenate([areas[:2].min(axis=1), areas[2:].max(axis=1)])


def find_overlapping(areas: Array, area: Array) -> Mask:
    """Find the boxes, shape (4, N), that overlap a box, shape (4,); return a mask, shape (N,)."""
    return np.logical_and.reduce([*(areas[:2] <= area[2:, None]), *(areas[2:] >= area[:2, None])])


def find_contained(areas: Array, area: Array) -> Mask:
    """Find the boxes, shape (4, N), that lie inside a box, shape (4,); return a mask, shape (N,)."""
    return np.logical_and.reduce([*(areas[:2] >= area[:2, None]), *(areas[2:] <= area[2:, None])])


FilledArea = tuple[Sequence[Array], str, float]
"""Closed curves, each of shape (K, 2), color, and opacity; by the even-odd rule, curves in curves are holes."""


class Fills(MultiPartItem):
    """Translucent or hatched areas with holes; `z` is the place in the stack of layers."""

    def __init__(self, z: float, pattern: Qt.BrushStyle = Qt.BrushStyle.SolidPattern) -> None:
        super().__init__(z)
        self._pattern = pattern
        self._areas: Sequence[FilledArea] = ()
        self._paths: dict[Hashable, QPainterPath] = {}

    def show_areas(self, areas: Sequence[FilledArea]) -> None:
        """Show areas, from the bottom of the stack to the top."""
        if areas or self.count:
            keys: list[Hashable] = [(*map(id, curves), color, opacity) for curves, color, opacity in areas]
            self.set_parts(keys, [np.concatenate(curves) for curves, *_ in areas])
            self._areas = areas  # the old ones live until here, so that no new one reuses an id
            self._paths = {key: self._paths[key] for key in keys if key in self._paths}

    def paint(self, painter: QPainter, option: QStyleOptionGraphicsItem, widget: QWidget | None = None) -> None:
        """Draw the areas."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        inverse = painter.worldTransform().inverted()[0]
        for index in self.find_visible_parts(painter, option)[0]:
            key, (curves, color, opacity) = self._keys[index], self._areas[index]
            if key not in self._paths:
                self._paths[key] = path = QPainterPath()  # filled by the even-odd rule
                for curve in curves:
                    path.addPolygon(_build_polygon(curve))
            tint = QColor(get_canvas_style().resolve_color(color))
            tint.setAlphaF(opacity)
            brush = QBrush(tint, self._pattern)
            brush.setTransform(inverse)  # keeps the hatch equally dense at any zoom
            painter.fillPath(self._paths[key], brush)
