"""The drawing layer: starts with their particles and handles, limits, placed charges, and the current draft."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import Signal
from PySide6.QtWidgets import QGraphicsItem

from app.model.document.document import Document
from app.model.text.language import tr
from app.model.volume.shape_sections import sections
from app.session.scene import Scene
from app.views.canvas.coordinates import to_xy
from app.views.canvas.items.curves import Curves
from app.views.canvas.items.discs import NO_POSITIONS, Discs
from app.views.canvas.items.item import Markers
from app.views.canvas.layers.drawn.charges import Charges
from app.views.canvas.layers.drawn.draft import Draft
from app.views.canvas.layers.drawn.limits import Limits
from app.views.canvas.layers.layer import Layer, Requests
from app.views.theme import theme
from cpm_core.numerics.types import Array, Place, Position
from cpm_core.shapes import (
    Charge,
    Circle,
    Ellipse,
    Everywhere,
    Grid,
    Kind,
    Limit,
    Points,
    Polygon,
    Sphere,
    Start,
    Stroke,
    Threshold,
)
from cpm_core.shapes.image_starts import ImageStart

_Z = 7.0
_FAINT, _LIGHT = 0.45, 0.55
"""Opacity of the drawing behind a run, and of particles that are computed from the image."""

_DIAMETERS: dict[Kind | None, float] = {"grid": 4.0, "gradient": 3.0, "centers": 6.0, None: 3.0}
"""Diameters of computed particles [px of the screen], smaller for kinds with many; None stands for areas."""

_Line = Circle | Ellipse | Polygon | Stroke
"""Starts that are shown as lines with their particles."""

_Area = Grid | Threshold
"""Starts that are shown as areas with their particles."""

_Drafted = tuple[tuple[Place, ...], tuple[Place, ...], str, bool]
"""Corners and path of a draft, its color, and whether it is closed."""


class DrawingLayer(Layer):
    """Shapes of the document; starts are opaque before a run and faint behind one."""

    name = "drawing"
    title = tr("Drawing")
    tip = tr("What a run starts from, regions of interest, barriers and placed charges.")
    shortcut = "Alt+6"
    in_slices = True
    drafting = Signal()
    """The draft or the ring has changed."""
    colors = (theme.DRAWING, theme.REGION, theme.BARRIER, theme.ATTRACTING, theme.REPELLING)

    def __init__(self, view: pg.ViewBox, requests: Requests) -> None:
        super().__init__(view, requests)
        self._lines = Curves(theme.DRAWING, _Z, width=1.4, kind="shapes")
        self._chosen = Curves(theme.CHOSEN, _Z + 0.1, width=2.2, kind="shapes")
        self._areas = Curves(theme.DRAWING, _Z, width=1.2, dashed=True, kind="shapes")
        self._everywhere = {kind: Discs(theme.MOVING, diameter, 0.0) for kind, diameter in _DIAMETERS.items()}
        self._seeds = Discs(theme.MOVING, 6.0, 0.0)
        self._points = Discs(theme.MOVING, 7.0, 0.0)
        self._chosen_points = Discs(theme.CHOSEN, 9.0, 0.0)
        self._handles = Markers(
            size=10.0, symbol="s", pen=pg.mkPen(theme.HALO, width=1.2), brush=pg.mkBrush(theme.CHOSEN)
        )
        self._limits = Limits(view)
        self._charges = Charges(view)
        self._draft = Draft(view)
        self.drafted: _Drafted = ((), (), theme.DRAWING, False)
        self.ringed: tuple[Place | None, float, str] = (None, 0.0, theme.DRAWING)
        self._image_starts: tuple[ImageStart, ...] = ()
        self._curves = (self._lines, self._areas, self._chosen)
        self._marks: tuple[QGraphicsItem, ...] = (
            *self._everywhere.values(),
            self._seeds,
            self._points,
            self._chosen_points,
            self._handles,
        )
        for z, item in enumerate(self._marks, start=2):
            item.setZValue(_Z + 0.1 * z)
        self.add(*self._curves, *self._marks)
        self._faint = 1.0
        self._chosen_start: ImageStart | None = None

    @property
    def everywhere(self) -> int:
        """Number of computed particles shown."""
        return sum(discs.count for discs in self._everywhere.values())

    def use_shape(self, shape: tuple[int, ...]) -> None:
        """Cover an image of this shape; shapes may lie beside it."""
        rim = float(max(shape))
        for item in (*self._curves, *self._everywhere.values(), self._seeds, self._points, self._chosen_points):
            item.use_shape(shape, rim)
        self._limits.use_shape(shape)
        self._charges.use_shape(shape)

    def follow(self, before: Scene) -> None:
        """Show other shapes, another selection, or the shapes behind a run."""
        scene = self.scene
        shapes, selected = scene.document.shapes, scene.selected
        if shapes is not before.document.shapes or (selected, scene.moved) != (before.selected, before.moved):
            self._show(scene.document, selected, scene.moved)
        elif scene.image_seeds is not before.image_seeds:
            self._draw_everywhere()

    def show_draft(self, corners: tuple[Place, ...], path: tuple[Place, ...], color: str, closed: bool) -> None:
        """Show the draft of a path."""
        self.drafted = (corners, path, color, closed)
        self._draft.show(self._flat(corners), self._flat(path), color, closed)
        self.drafting.emit()

    def show_ring(self, center: Place | None, radius: float, color: str) -> None:
        """Show the ring of a tool, in a volume that of a ball in sides of the smallest voxel; None hides it."""
        self.ringed = (center, radius, color)
        self._draft.show_ring(self._ring(center, radius), color)
        self.drafting.emit()

    def _flat(self, places: tuple[Place, ...]) -> tuple[Position, ...]:
        """Places as (row, col) in the slice that is shown."""
        slices = self.scene.slices
        return tuple(slices.current.within(place) if slices and len(place) == 3 else place for place in places)

    def _ring(self, center: Place | None, radius: float) -> Array:
        """The line of a ring, shape (K, 2)."""
        if center is None:
            return np.empty((0, 2))
        slices, volume = self.scene.slices, self.scene.volume
        if slices is None or volume is None or len(center) == 2:
            return Circle(center, radius).outline
        cuts = sections(Sphere.round(center, radius, volume.spacing), slices.axis, slices.current.index)
        return np.concatenate([np.empty((0, 2)), *(cut.outline for cut in cuts)])

    def copy_draft(self, other: DrawingLayer) -> None:
        """Show the same draft and ring on another canvas."""
        if self.drafted != other.drafted:
            other.show_draft(*self.drafted)
        if self.ringed != other.ringed:
            other.show_ring(*self.ringed)

    def _show(self, document: Document, selected: int | None, started: bool) -> None:
        chosen = document.shapes[selected] if selected is not None and selected < len(document.shapes) else None
        rest = [shape for shape in document.shapes if shape is not chosen]
        self._lines.show([shape.outline for shape in rest if isinstance(shape, _Line)])
        self._areas.show([shape.outline for shape in rest if isinstance(shape, _Area)])
        self._chosen.show([chosen.outline] if isinstance(chosen, _Line | _Area) else [])
        # During a run, the points that the particles started from would only hide them.
        placed: list[Points | Grid] = [shape for shape in document.shapes if isinstance(shape, Grid)]
        placed += [shape for shape in rest if isinstance(shape, Points)]
        self._points.show(_particles([] if started else placed))
        self._chosen_points.show(_particles([chosen] if isinstance(chosen, Points | Stroke) else []))
        # A selected circle shows its handles; a selected stroke is recognized only by its particles.
        lines = [*rest, *([chosen] if isinstance(chosen, Circle | Ellipse | Polygon) else [])]
        self._seeds.show(_particles([] if started else [line for line in lines if isinstance(line, _Line)]))
        self._image_starts = () if started else document.image_starts
        self._draw_everywhere()
        x, y = to_xy(np.array(chosen.handles() if chosen else (), dtype=float).reshape(-1, 2))
        self._handles.setData(x=x, y=y)
        self._faint = _FAINT if started and not isinstance(chosen, Start) else 1.0
        self._chosen_start = chosen if isinstance(chosen, ImageStart) else None
        self.fade()
        limits = [shape for shape in document.shapes if isinstance(shape, Limit)]
        self._limits.show(limits, chosen if isinstance(chosen, Limit) else None)
        charges = [shape for shape in document.shapes if isinstance(shape, Charge)]
        self._charges.show(charges, chosen if isinstance(chosen, Charge) else None)

    def show_or_hide(self) -> None:
        """Show or hide all items."""
        super().show_or_hide()
        self._limits.set_visible(self.shown)
        self._charges.set_visible(self.shown)

    def fade(self) -> None:
        """Set the opacity; the drawing is faint behind a run."""
        faint: tuple[QGraphicsItem, ...] = (*self._curves, *self._marks)
        for item in faint:
            item.setOpacity(self.opacity * self._faint)
        self._handles.setOpacity(self.opacity)
        chosen = self._chosen_start
        for kind, discs in self._everywhere.items():
            strong = isinstance(chosen, Threshold) if kind is None else chosen == Everywhere(kind)
            discs.setOpacity(self.opacity * (1.0 if strong else _LIGHT))

    def _draw_everywhere(self) -> None:
        for kind, discs in self._everywhere.items():
            seen = [
                self.scene.image_seeds[start]
                for start in self._image_starts
                if start in self.scene.image_seeds and _kind(start) == kind
            ]
            discs.show(np.concatenate([NO_POSITIONS, *seen]))


def _kind(start: ImageStart) -> Kind | None:
    return start.kind if isinstance(start, Everywhere) else None


def _particles(shapes: Sequence[_Line | Points | Grid]) -> np.ndarray:
    return np.concatenate([np.empty((0, 2)), *(shape.seeds() for shape in shapes)])
