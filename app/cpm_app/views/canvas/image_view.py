"""A view of an image and the layers over it, with zoom and pan."""

from __future__ import annotations

import math

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QContextMenuEvent, QPixmap, QResizeEvent

from cpm_app.model.volume.slices import Slice, flips_of
from cpm_app.session.features.slices import Sections
from cpm_app.session.scene import Scene
from cpm_app.views.items.item import image_rectangle, to_position
from cpm_app.views.layers import Layers
from cpm_app.views.layers.layer import NoRequests, Requests
from cpm_app.views.theme import theme
from cpm_app.views.widgets.turns import Turns
from cpm_core.numerics import Place, Position
from cpm_core.numerics.types import Entries, Extent, Plain

_MARGIN = 0.04

REACH = 8.0
"""Distance from a line or handle within which the pointer takes hold of it [px of the screen]."""

LEAST, MOST = 0.01, 64.0
"""Bounds of the magnification."""

_AROUND, _SMALLEST = 0.15, 12.0
"""Margin around a part that is shown, as a fraction of it, and the least extent of such a part [px of the image]."""


class ImageView(pg.GraphicsView):  # type: ignore[misc]  # pyqtgraph has no type hints
    """Shows the `layers` of a scene in the box `view`, and zooms and pans; `requests` asks the worker for data.

    Of a volume it shows a slice, as `sections` makes it; positions are (row, col) in what is shown. One with an
    `original` follows the settings of its layers, which have asked for all data.
    """

    def __init__(self, requests: Requests | None = None, original: ImageView | None = None) -> None:
        super().__init__(background=theme.CANVAS)
        self.view = pg.ViewBox(enableMenu=False, invertY=True, lockAspect=True, enableMouse=False, defaultPadding=0.0)
        self.view.disableAutoRange()
        # It fills itself: else the window and all panels around it would be drawn below it in every frame.
        self.viewport().setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setCentralItem(self.view)
        self.layers = Layers(self.view, requests or NoRequests())
        self.sections = Sections()
        self._given = self.drawn = Scene()
        """The scene that is given, and the one that is drawn: of a volume, that of a slice."""
        self._fitted = True
        self._original = original
        if original is not None:
            self.setMinimumSize(1, 1)
            self.setFrameStyle(0)
            for layer in original.layers:
                # Qt disconnects a method with its view; a function it would keep, and with it the view.
                layer.changed.connect(self._copy_settings)

    @property
    def shape(self) -> Extent | None:
        """Shape of the image; None while there is none."""
        return self.drawn.image.shape if self.drawn.image is not None else None

    def draw(self, scene: Scene) -> None:
        """Draw a scene; another image, or slices across another axis, are shown as a whole."""
        self._given = scene
        before, self.drawn = self.drawn, self.sections.of(scene)
        if self.drawn.ground != before.ground:
            upside_down, leftward = self._flips
            self.view.invertY(not upside_down)
            self.view.invertX(leftward)
            if _aspect(self.drawn) != _aspect(before):
                self.view.setAspectLocked(True, _aspect(self.drawn))
            self.use_image()
        self.layers.draw(self.drawn)
        if scene.whole is not before.whole:
            self._copy_settings()  # a new image resets the options of its layer

    def _copy_settings(self) -> None:
        for layer in self._original.layers if self._original is not None else ():
            self.layers[layer.name].use_view_state(layer.view_state())

    def draw_again(self) -> None:
        """Draw what has been made of the scene since."""
        self.draw(self._given)

    def use_image(self) -> None:
        """Begin with another image."""
        self.fit()

    def fit(self) -> None:
        """Show the whole image."""
        if self.shape is not None:
            self.view.setRange(image_rectangle(self.shape), padding=_MARGIN)
            self._fitted = True

    @property
    def magnification(self) -> float:
        """Pixels of the screen per pixel of the image."""
        return float(self.devicePixelRatioF() / max(self.view.viewPixelSize()[0], 1e-12))

    def zoom(self, factor: float, around: QPointF | None = None) -> None:
        """Enlarge by `factor` around a point of the widget, by default its center."""
        now = self.magnification
        factor = min(max(factor, min(LEAST / now, 1.0)), max(MOST / now, 1.0))
        point = self.rect().center() if around is None else around.toPoint()
        self.view.scaleBy((1.0 / factor, 1.0 / factor), center=self.view.mapSceneToView(self.mapToScene(point)))
        self._fitted = False

    def zoom_to(self, magnification: float) -> None:
        """Show so many pixels of the screen per pixel of the image, around the center."""
        if 0.0 < magnification < math.inf:
            self.zoom(magnification / self.magnification)

    def show_part(self, part: QRectF) -> None:
        """Show a part of the image as large as possible, with a margin."""
        wide = max(_SMALLEST - part.width(), 0.0) / 2 + _AROUND * part.width()
        high = max(_SMALLEST - part.height(), 0.0) / 2 + _AROUND * part.height()
        self._show(part.adjusted(-wide, -high, wide, high))

    def _show(self, part: QRectF) -> None:
        self.view.setRange(part, padding=0.0)
        self._fitted = False

    def pan(self, right: float, down: float) -> None:
        """Move the visible part by pixels of the screen."""
        if right or down:
            width, height = self.view.viewPixelSize()
            row, col = self.toward(down * height, right * width)
            self.view.translateBy(x=col, y=row)
            self._fitted = False

    def toward(self, down: float, right: float) -> Position:
        """Displacement (row, col) in the image that leads down and to the right on the screen."""
        upside_down, leftward = self._flips
        return -down if upside_down else down, -right if leftward else right

    def look_at(self, place: Position, span: float) -> None:
        """Show a square of `span` px of the image around a place (row, col)."""
        self._show(QRectF(place[1] - span / 2, place[0] - span / 2, span, span))

    def position(self, point: QPointF) -> Position:
        """Position (row, col) under a point of the widget."""
        return to_position(self.view.mapSceneToView(self.mapToScene(point.toPoint())))

    def point(self, position: Position) -> QPointF:
        """Point of the widget over a position (row, col)."""
        return QPointF(self.mapFromScene(self.view.mapViewToScene(QPointF(position[1], position[0]))))

    def view_state(self) -> Entries:
        """Visible part, unless it is the whole image, and state of each layer, as plain JSON for a session file."""
        seen = self.view.viewRect()
        place = {} if self._fitted else {"center": [seen.center().y(), seen.center().x()], "rows": seen.height()}
        return {"place": place, "layers": {layer.name: layer.view_state() for layer in self.layers}}

    def use_view_state(self, state: Plain) -> None:
        """Restore the state from a session file; missing or invalid entries change nothing."""
        place, layers = (found if isinstance(found := state.get(name), dict) else {} for name in ("place", "layers"))
        for layer in self.layers:
            kept = layers.get(layer.name)
            if isinstance(kept, dict):
                layer.use_view_state(kept)
        self.fit()
        center, seen = place.get("center"), self.view.viewRect()
        numbers = [*center, place.get("rows")] if isinstance(center, list) else []
        if len(numbers) == 3 and all(isinstance(number, int | float) and abs(number) <= 1e6 for number in numbers):
            row, col, high = numbers
            wide = high * seen.width() / seen.height()
            if high >= 0.01:
                self._show(QRectF(col - 0.5 * wide, row - 0.5 * high, wide, high))

    def finish(self) -> None:
        """Draw now what would be drawn in later turns."""
        for turns in self.scene().findChildren(Turns):
            turns.finish()

    def grab(self) -> QPixmap:
        """A picture of all it shows."""
        self.finish()
        return super().grab()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep the whole image visible until the user zooms."""
        super().resizeEvent(event)
        if getattr(self, "_fitted", False):
            self.fit()

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Leave the menu by keys to the window; the right button opens it when it is released without a drag."""
        event.setAccepted(event.reason() == QContextMenuEvent.Reason.Mouse)

    @property
    def here(self) -> Slice | None:
        """The slice that is shown; None for an image."""
        return None if self.drawn.slices is None else self.drawn.slices.current

    def placed(self, position: Position) -> Place:
        """Place in the image, or in the volume, of a position in what is shown."""
        return position if self.here is None else self.here.lifted(position)

    def reach(self) -> float:
        """Distance at which the pointer takes hold of something [px of the image]."""
        return REACH * float(self.view.viewPixelSize()[0])

    @property
    def _flips(self) -> tuple[bool, bool]:
        """Whether it is shown upside down, and mirrored, as slices of a patient are read."""
        return flips_of(self.drawn.whole, None if self.here is None else self.here.axis)


def _aspect(scene: Scene) -> float:
    """Width of a pixel in heights of a pixel: one but in slices of a volume, which are shown as they are in space."""
    if scene.slices is None or scene.image is None:
        return 1.0
    row, col = scene.image.spacing
    return col / row
