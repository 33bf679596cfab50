"""The layer that shows what is drawn: circles with their handles, and points."""

from __future__ import annotations

import numpy as np
import pyqtgraph as pg

from app.model.document import Document
from app.model.shapes import Circle, Points, Shape
from app.views import theme
from app.views.coordinates import to_xy
from app.views.layers import joined, line_pen
from app.views.particle_layer import Discs

_CORNERS = 180


class DrawingLayer:
    """Shapes of the document; strong while they are about to start a run, faint behind one."""

    def __init__(self, view: pg.ViewBox) -> None:
        self._halo = pg.PlotCurveItem(pen=line_pen(theme.HALO, 3.6), antialias=True)
        self._circles = pg.PlotCurveItem(pen=line_pen(theme.DRAWING, 1.4), antialias=True)
        self._chosen = pg.PlotCurveItem(pen=line_pen(theme.CHOSEN, 2.2), antialias=True)
        self._seeds = Discs(theme.MOVING, 6.0, 0.0)
        self._points = Discs(theme.MOVING, 7.0, 0.0)
        self._chosen_points = Discs(theme.CHOSEN, 9.0, 0.0)
        self._handles = pg.ScatterPlotItem(
            size=10.0, symbol="s", pen=pg.mkPen(theme.HALO, width=1.2), brush=pg.mkBrush(theme.CHOSEN)
        )
        self._items = (
            self._halo,
            self._circles,
            self._chosen,
            self._seeds,
            self._points,
            self._chosen_points,
            self._handles,
        )
        for z, item in enumerate(self._items):
            item.setZValue(7 + 0.1 * z)
            view.addItem(item, ignoreBounds=True)

    def use_shape(self, shape: tuple[int, ...]) -> None:
        """Make room for an image of this shape and for what is drawn beside it."""
        for item in (self._seeds, self._points, self._chosen_points):
            item.use_shape(shape, rim=float(max(shape)))

    def show(self, document: Document, selected: int | None, started: bool) -> None:
        """Show the shapes of a document."""
        chosen = document.shapes[selected] if selected is not None and selected < len(document.shapes) else None
        rest = [shape for shape in document.shapes if shape is not chosen]
        self._draw_circles(self._halo, list(document.shapes))
        self._draw_circles(self._circles, rest)
        self._draw_circles(self._chosen, [chosen] if chosen else [])
        # Once the particles have left, the points that they came from would only hide them.
        self._draw_points(self._points, [] if started else rest)
        self._draw_points(self._chosen_points, [chosen] if chosen else [])
        circles = [shape.seeds() for shape in document.shapes if isinstance(shape, Circle) and not started]
        self._seeds.show(np.concatenate(circles) if circles else np.empty((0, 2)))
        x, y = to_xy(np.array(chosen.handles() if chosen else (), dtype=float).reshape(-1, 2))
        self._handles.setData(x=x, y=y)
        for item in self._items:
            item.setOpacity(0.45 if started and chosen is None else 1.0)

    def set_visible(self, visible: bool) -> None:
        """Show or hide it all."""
        for item in self._items:
            item.setVisible(visible)

    @staticmethod
    def _draw_circles(item: pg.PlotCurveItem, shapes: list[Shape]) -> None:
        x, y, connect = joined([_outline(shape) for shape in shapes if isinstance(shape, Circle)])
        item.setData(x, y, connect=connect)

    @staticmethod
    def _draw_points(item: Discs, shapes: list[Shape]) -> None:
        positions = [shape.seeds() for shape in shapes if isinstance(shape, Points)]
        item.show(np.concatenate(positions) if positions else np.empty((0, 2)))


def _outline(circle: Circle) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS)
    return np.array(circle.center) + circle.radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)
