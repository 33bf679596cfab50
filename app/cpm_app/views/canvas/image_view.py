"""A view of an image and the layers over it, with zoom and pan."""

from __future__ import annotations

import math

import pyqtgraph as pg
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QContextMenuEvent, QPixmap, QResizeEvent

from cpm_app.model.volume.slices import Slice, find_slice_flips
from cpm_app.session.features.slices import Sections
from cpm_app.session.scene import Scene
from cpm_app.session.session import Session
from cpm_app.views.items.item import image_rectangle, to_position
from cpm_app.views.layers import Layers
from cpm_app.views.theme import theme
from cpm_app.views.widgets.turns import Turns
from cpm_core.numerics import Place, Position
from cpm_core.numerics.types import Extent, JsonDict, JsonObject

_FIT_PADDING = 0.04
"""Padding around the whole image, as a fraction of its extent."""

_HIT_TOLERANCE = 8.0
"""Distance within which the pointer grabs a line or handle [px of the screen]."""

_MIN_MAGNIFICATION = 0.01
"""Smallest magnification that the user can zoom to."""

_MAX_MAGNIFICATION = 64.0
"""Largest magnification that the user can zoom to."""

_PART_MARGIN = 0.15
"""Margin around a part that is zoomed to, as a fraction of its extent."""

_MIN_PART_EXTENT = 12.0
"""Smallest extent of a part that is zoomed to [px of the image]."""


class ImageView(pg.GraphicsView):  # type: ignore[misc]  # pyqtgraph has no type hints
    """Shows the `layers` of a scene in the box `view`, and zooms and pans; the worker of `session` is asked for data.

    Of a volume it shows the slice that `sections` cuts; positions are (row, col) in the slice. A view with an
    `original` copies the settings of its layers, which have already requested all data.
    """

    def __init__(self, session: Session | None = None, original: ImageView | None = None) -> None:
        super().__init__(background=theme.CANVAS_COLOR)
        self.view = pg.ViewBox(enableMenu=False, invertY=True, lockAspect=True, enableMouse=False, defaultPadding=0.0)
        self.view.disableAutoRange()
        # The view fills its own background; else Qt would draw the window and its panels below it in every frame.
        self.viewport().setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setCentralItem(self.view)
        self.layers = Layers(self.view, session)
        self.sections = Sections()
        self._given_scene = self.drawn_scene = Scene()
        """The scene passed in, and the scene drawn, which for a volume is a slice."""
        self._fitted = True
        self._original = original
        if original is not None:
            self.setMinimumSize(1, 1)
            self.setFrameStyle(0)
            for layer in original.layers:
                # Qt disconnects a method when its view is deleted; it would keep a function, and with it the view.
                layer.changed.connect(self._copy_settings)

    @property
    def shape(self) -> Extent | None:
        """Shape of the image; None while there is none."""
        return self.drawn_scene.image.shape if self.drawn_scene.image is not None else None

    def draw_scene(self, scene: Scene) -> None:
        """Draw a scene; fit the view when the image or the axis of the slices has changed."""
        self._given_scene = scene
        before, self.drawn_scene = self.drawn_scene, self.sections.from_scene(scene)
        if self.drawn_scene.view_source != before.view_source:
            upside_down, leftward = self._flips
            self.view.invertY(not upside_down)
            self.view.invertX(leftward)
            if _pixel_aspect(self.drawn_scene) != _pixel_aspect(before):
                self.view.setAspectLocked(True, _pixel_aspect(self.drawn_scene))
            self.on_image_changed()
        self.layers.draw_scene(self.drawn_scene)
        if scene.full_image is not before.full_image:
            self._copy_settings()  # a new image resets the options of its layer

    def _copy_settings(self) -> None:
        for layer in self._original.layers if self._original is not None else ():
            self.layers[layer.name].use_view_state(layer.view_state())

    def redraw_scene(self) -> None:
        """Draw the last scene again, with parts of slices computed since."""
        self.draw_scene(self._given_scene)

    def on_image_changed(self) -> None:
        """Fit the view to another image."""
        self.fit_image()

    def fit_image(self) -> None:
        """Show the whole image."""
        if self.shape is not None:
            self.view.setRange(image_rectangle(self.shape), padding=_FIT_PADDING)
            self._fitted = True

    @property
    def magnification(self) -> float:
        """Pixels of the screen per pixel of the image."""
        return float(self.devicePixelRatioF() / max(self.view.viewPixelSize()[0], 1e-12))

    def zoom_by(self, factor: float, around: QPointF | None = None) -> None:
        """Enlarge by `factor` around a point of the widget, by default its center."""
        now = self.magnification
        factor = min(max(factor, min(_MIN_MAGNIFICATION / now, 1.0)), max(_MAX_MAGNIFICATION / now, 1.0))
        point = self.rect().center() if around is None else around.toPoint()
        self.view.scaleBy((1.0 / factor, 1.0 / factor), center=self.view.mapSceneToView(self.mapToScene(point)))
        self._fitted = False

    def zoom_to(self, magnification: float) -> None:
        """Set the magnification, in pixels of the screen per pixel of the image, around the center."""
        if 0.0 < magnification < math.inf:
            self.zoom_by(magnification / self.magnification)

    def show_part(self, part: QRectF) -> None:
        """Show a part of the image as large as possible, with a margin."""
        wide = max(_MIN_PART_EXTENT - part.width(), 0.0) / 2 + _PART_MARGIN * part.width()
        high = max(_MIN_PART_EXTENT - part.height(), 0.0) / 2 + _PART_MARGIN * part.height()
        self._show_rectangle(part.adjusted(-wide, -high, wide, high))

    def _show_rectangle(self, part: QRectF) -> None:
        self.view.setRange(part, padding=0.0)
        self._fitted = False

    def pan_by(self, right: float, down: float) -> None:
        """Move the visible part by pixels of the screen."""
        if right or down:
            width, height = self.view.viewPixelSize()
            row, col = self.image_displacement(down * height, right * width)
            self.view.translateBy(x=col, y=row)
            self._fitted = False

    def image_displacement(self, down: float, right: float) -> Position:
        """Return the displacement (row, col) in the image for a move down and right on the screen."""
        upside_down, leftward = self._flips
        return -down if upside_down else down, -right if leftward else right

    def look_at(self, place: Position, span: float) -> None:
        """Show a square of `span` px of the image around a place (row, col)."""
        self._show_rectangle(QRectF(place[1] - span / 2, place[0] - span / 2, span, span))

    def map_to_image(self, point: QPointF) -> Position:
        """Return the position (row, col) under a point of the widget."""
        return to_position(self.view.mapSceneToView(self.mapToScene(point.toPoint())))

    def map_from_image(self, position: Position) -> QPointF:
        """Return the point of the widget over a position (row, col)."""
        return QPointF(self.mapFromScene(self.view.mapViewToScene(QPointF(position[1], position[0]))))

    def view_state(self) -> JsonDict:
        """Return the state of each layer, and the visible part unless it is the whole image, as JSON."""
        seen = self.view.viewRect()
        place = {} if self._fitted else {"center": [seen.center().y(), seen.center().x()], "rows": seen.height()}
        return {"place": place, "layers": {layer.name: layer.view_state() for layer in self.layers}}

    def use_view_state(self, state: JsonObject) -> None:
        """Restore the state from a session file; missing or invalid entries change nothing."""
        place, layers = (found if isinstance(found := state.get(name), dict) else {} for name in ("place", "layers"))
        for layer in self.layers:
            kept = layers.get(layer.name)
            if isinstance(kept, dict):
                layer.use_view_state(kept)
        self.fit_image()
        center, seen = place.get("center"), self.view.viewRect()
        numbers = [*center, place.get("rows")] if isinstance(center, list) else []
        if len(numbers) == 3 and all(isinstance(number, int | float) and abs(number) <= 1e6 for number in numbers):
            row, col, high = numbers
            wide = high * seen.width() / seen.height()
            if high >= 0.01:
                self._show_rectangle(QRectF(col - 0.5 * wide, row - 0.5 * high, wide, high))

    def finish_drawing(self) -> None:
        """Draw everything now that is scheduled for later turns of the event loop."""
        for turns in self.scene().findChildren(Turns):
            turns.finish()

    def grab(self) -> QPixmap:
        """Take a picture of the complete view."""
        self.finish_drawing()
        return super().grab()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Keep the whole image visible until the user zooms."""
        super().resizeEvent(event)
        if getattr(self, "_fitted", False):
            self.fit_image()

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:
        """Leave menus opened by key to the window; the right button opens a menu when released without a drag."""
        event.setAccepted(event.reason() == QContextMenuEvent.Reason.Mouse)

    @property
    def shown_slice(self) -> Slice | None:
        """Slice that is shown; None for an image."""
        return None if self.drawn_scene.slices is None else self.drawn_scene.slices.current

    def place_at(self, position: Position) -> Place:
        """Return the place in the image or in the volume of a position in the view."""
        return position if self.shown_slice is None else self.shown_slice.lift_position(position)

    def hit_tolerance(self) -> float:
        """Return the distance within which the pointer hits a line or handle [px of the image]."""
        return _HIT_TOLERANCE * float(self.view.viewPixelSize()[0])

    @property
    def _flips(self) -> tuple[bool, bool]:
        """Whether the view is upside down, and whether it is mirrored, by the radiological convention."""
        return find_slice_flips(self.drawn_scene.full_image, self.shown_slice)


def _pixel_aspect(scene: Scene) -> float:
    """Return the width of a pixel over its height as drawn; 1 except in slices of anisotropic volumes."""
    if scene.slices is None or scene.image is None:
        return 1.0
    row, col = scene.image.spacing
    return col / row
