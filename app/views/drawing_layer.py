"""The layer that shows what is drawn: starts with their particles and handles, limits, and what is being drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg

from app.model.document import NOWHERE, Document, Sown
from app.model.paths import Position
from app.model.shapes import Circle, Everywhere, Kind, Limit, Points, Stroke
from app.views import theme
from app.views.coordinates import to_xy
from app.views.curves import Curves
from app.views.draft_layer import DraftLayer
from app.views.limit_layer import LimitLayer
from app.views.particle_layer import Discs

_Z = 7.0
_CORNERS = 180
_FAINT, _LIGHT = 0.45, 0.55
"""Opacity of the drawing behind a run, and of particles that nobody has drawn one by one."""

_DIAMETERS: dict[Kind, float] = {"grid": 4.0, "edges": 3.0, "centers": 6.0}
"""Diameters of the latter, the smaller the more there are of them [px of the screen]."""


class DrawingLayer:
    """Shapes of the document; starts are strong while they are about to start a run, faint behind one."""

    def __init__(self, view: pg.ViewBox) -> None:
        self._lines = Curves(theme.DRAWING, _Z, width=1.4)
        self._chosen = Curves(theme.CHOSEN, _Z + 0.1, width=2.2)
        self._everywhere = {kind: Discs(theme.MOVING, diameter, 0.0) for kind, diameter in _DIAMETERS.items()}
        self._seeds = Discs(theme.MOVING, 6.0, 0.0)
        self._points = Discs(theme.MOVING, 7.0, 0.0)
        self._chosen_points = Discs(theme.CHOSEN, 9.0, 0.0)
        self._handles = pg.ScatterPlotItem(
            size=10.0, symbol="s", pen=pg.mkPen(theme.HALO, width=1.2), brush=pg.mkBrush(theme.CHOSEN)
        )
        self._limits = LimitLayer(view)
        self._draft = DraftLayer(view)
        self._sown: Sown = NOWHERE
        self._kinds: tuple[Kind, ...] = ()
        self._curves = (self._lines, self._chosen)
        self._items = (
            *self._everywhere.values(),
            self._seeds,
            self._points,
            self._chosen_points,
            self._handles,
        )
        for z, item in enumerate(self._items, start=2):
            item.setZValue(_Z + 0.1 * z)
        for item in (*self._curves, *self._items):
            view.addItem(item, ignoreBounds=True)

    @property
    def everywhere(self) -> int:
        """Number of particles shown that nobody has drawn one by one."""
        return sum(discs.count for discs in self._everywhere.values())

    def use_shape(self, shape: tuple[int, ...]) -> None:
        """Make room for an image of this shape and for what is drawn beside it."""
        rim = float(max(shape))
        for curves in self._curves:
            curves.use_shape(shape, rim)
        for discs in (*self._everywhere.values(), self._seeds, self._points, self._chosen_points):
            discs.use_shape(shape, rim)
        self._limits.use_shape(shape)
        self._sown = NOWHERE

    def show_sown(self, sown: Sown) -> None:
        """Show where particles start all over the image."""
        self._sown = sown
        self._draw_everywhere()

    def show_draft(self, corners: tuple[Position, ...], path: tuple[Position, ...], colour: str, closed: bool) -> None:
        """Show a path that is being drawn."""
        self._draft.show(corners, path, colour, closed)

    def show(self, document: Document, selected: int | None, started: bool) -> None:
        """Show the shapes of a document."""
        chosen = document.shapes[selected] if selected is not None and selected < len(document.shapes) else None
        rest = [shape for shape in document.shapes if shape is not chosen]
        self._lines.show([_line(shape) for shape in rest if isinstance(shape, Circle | Stroke)])
        self._chosen.show([_line(chosen)] if isinstance(chosen, Circle | Stroke) else [])
        # Once the particles have left, the points that they came from would only hide them.
        self._points.show(_particles([] if started else [shape for shape in rest if isinstance(shape, Points)]))
        self._chosen_points.show(_particles([chosen] if isinstance(chosen, Points | Stroke) else []))
        # A chosen circle shows its handles, a chosen stroke has nothing to be told by but its particles.
        lines = [*rest, *([chosen] if isinstance(chosen, Circle) else [])]
        self._seeds.show(_particles([] if started else [line for line in lines if isinstance(line, Circle | Stroke)]))
        self._kinds = () if started else document.everywhere
        self._draw_everywhere()
        x, y = to_xy(np.array(chosen.handles() if chosen else (), dtype=float).reshape(-1, 2))
        self._handles.setData(x=x, y=y)
        for item in (*self._curves, *self._items):
            item.setOpacity(_FAINT if started and (chosen is None or isinstance(chosen, Limit)) else 1.0)
        self._handles.setOpacity(1.0)
        for kind, discs in self._everywhere.items():
            discs.setOpacity(1.0 if chosen == Everywhere(kind) else _LIGHT)
        limits = [shape for shape in document.shapes if isinstance(shape, Limit)]
        self._limits.show(limits, chosen if isinstance(chosen, Limit) else None)

    def set_visible(self, visible: bool) -> None:
        """Show or hide it all."""
        for item in self._curves:
            item.set_wanted(visible)
        for item in self._items:
            item.setVisible(visible)
        self._limits.set_visible(visible)

    def _draw_everywhere(self) -> None:
        for kind, discs in self._everywhere.items():
            discs.show(self._sown[kind] if kind in self._kinds and kind in self._sown else np.empty((0, 2)))


def _particles(shapes: Sequence[Circle | Points | Stroke]) -> np.ndarray:
    return np.concatenate([np.empty((0, 2)), *(shape.seeds() for shape in shapes)])


def _line(shape: Circle | Stroke) -> np.ndarray:
    if isinstance(shape, Stroke):
        return np.array(shape.points)
    angle = np.linspace(0.0, 2.0 * np.pi, _CORNERS)
    return np.array(shape.center) + shape.radius * np.stack([np.sin(angle), np.cos(angle)], axis=1)
