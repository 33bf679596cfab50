"""The canvas with the line below it; it follows the session."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QGridLayout, QVBoxLayout, QWidget

from app.model.document import edits
from app.model.text.keys import with_keys
from app.model.text.language import from_core, tr
from app.session.features.workspace import Workspace
from app.session.scene import Scene
from app.session.signals import OF_THE_PROGRAM, OPENING
from app.views.canvas.canvas import Canvas
from app.views.canvas.crosshair import Crosshair
from app.views.canvas.image_view import ImageView
from app.views.canvas.layers.image_layer import LevelDrag
from app.views.canvas.legend import Strip
from app.views.canvas.pointed import Pointed, part_around, selected_places
from app.views.canvas.tools import TOOLS
from app.views.canvas.tools.select import SelectTool
from app.views.canvas.tools.tool import Tool, ToolContext
from app.views.widgets.containers import OfferBar
from cpm_core import Image
from cpm_core.numerics import Place, Position
from cpm_core.shapes import Circle, Shape, Sphere

FIRST_TOOL = "circle"
OFFERED = tr("Enter accepts what was found, the tool Objects ({key:objects}) corrects it, {key:escape} discards it.")

_ARROWS = {
    Qt.Key.Key_Up: (-1.0, 0.0),
    Qt.Key.Key_Down: (1.0, 0.0),
    Qt.Key.Key_Left: (0.0, -1.0),
    Qt.Key.Key_Right: (0.0, 1.0),
}
_SIZES = {Qt.Key.Key_Less: -1.0, Qt.Key.Key_Greater: 1.0}
_DRAFT_KEYS = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Backspace)
_PAN = 40.0
_MIDDLE_FRACTION = 0.2


class CanvasArea(QWidget):
    """Shows the scene of a session on the canvas, and lets the tools edit its document and select contours."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._workspace = workspace
        self._session = session = workspace.session
        self._review = review = workspace.review
        self._selection = workspace.object_selection
        self.canvas = Canvas(session)
        self.strip = Strip(self.canvas.layers.legend)
        self.messages, self.hint = self.strip.messages, self.strip.hint
        self._pointed = Pointed(workspace)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        self.offers, self.controls = OfferBar(), QVBoxLayout()
        """The line above the canvas, and those below it, which features add."""
        layout.addWidget(self.offers)
        self.views = _grid_around(self.canvas)
        """The canvas, and views next to it, which features add."""
        layout.addLayout(self.views, 1)
        layout.addLayout(self.controls)
        layout.addWidget(self.strip)
        self.crosshair = Crosshair(self.canvas, lambda: self.show_hint(self._hint))
        self._hint = ""
        tools = ToolContext(
            session,
            review,
            workspace.hand_editing,
            workspace.object_selection,
            workspace.object_list,
            workspace.slices,
            self.canvas.layers.drawing,
            advised=lambda: self.show_hint(self._hint),
        )
        self._tools: dict[str, Tool] = {entry.name: entry.make(tools) for entry in TOOLS}
        self.canvas.hold.grip = SelectTool(tools)
        self.canvas.installEventFilter(self)
        self.level_drag = LevelDrag(self.canvas.layers.image, self.canvas.viewport())
        self.use_tool(FIRST_TOOL)
        session.said.connect(self.messages.say)
        session.attempted.connect(self.messages.attempt)
        session.image_changed.connect(lambda: self.messages.keep_only(OPENING, *OF_THE_PROGRAM))
        for layer in self.canvas.layers:
            layer.changed.connect(self.strip.legend.refresh)
        session.status_changed.connect(self.refresh)
        session.scene_changed.connect(self._draw)
        workspace.other_result.changed.connect(self._draw)
        self._selection.changed.connect(self.refresh)
        workspace.object_list.selection_changed.connect(self.refresh)
        self.canvas.layers.contours.changed.connect(self._follow_contours)
        self._draw()

    def use_tool(self, name: str) -> None:
        """Change the tool, and give the keyboard to the canvas.

        A drawing tool deselects the shape, because its handles would be in the way.
        """
        self.canvas.use(self._tools[name])
        if name != "select":
            self._session.select(None)
        self.crosshair.move(0.0, 0.0)
        self.canvas.setFocus()
        self.show_hint(self._hint)

    def menu_at(self, point: QPoint | None) -> tuple[str, QPoint]:
        """What lies at a point, or at the cross-hair, or is chosen; see `MenuOwner`."""
        keyed = self.crosshair.at
        if point is None and keyed is None:
            return self._pointed.chosen, self.rect().center()
        view = self.canvas if point is None else self._view_at(point)
        inside = QPointF(view.mapFrom(self, point)) if point is not None else view.point(keyed or (0, 0))
        thing = self._pointed.choose(view.placed(view.position(inside)), view.reach(), view.here)
        return thing, view.mapTo(self, inside.toPoint())

    def _view_at(self, point: QPoint) -> ImageView:
        """The view of an image or slice at a point: the canvas, or one next to it."""
        widget = self.childAt(point)
        while widget is not None and not isinstance(widget, ImageView):
            widget = widget.parentWidget()
        return widget or self.canvas

    def escape(self) -> None:
        """Cancel the draft or hide the cross-hair; otherwise dismiss the message and deselect everything."""
        if self.canvas.hold.gesturing:
            self.canvas.hold.cancel()
        elif self.crosshair.at is not None:
            self.crosshair.hide()
        elif self._workspace.other_result.chosen is not None:
            self._workspace.other_result.choose(None)
        else:
            self.messages.dismiss()
            self._session.select(None)
            self._review.select(())
            self._selection.dismiss()

    def refresh(self) -> None:
        """Update the hint."""
        self.show_hint(self._session.resolved.hint)

    def show_hint(self, text: str) -> None:
        """Show what to do next below the canvas; advice of the tool has priority."""
        self._hint = text
        tool = self.canvas.hold.tool
        if tool is not None and self._session.document.image is not None:
            offered = with_keys(OFFERED) if self._selection.proposals and not self._selection.selecting else ""
            text = self.crosshair.advice or tool.advice or offered or text
        self.strip.say_next(text)

    def zoom_to_selection(self) -> None:
        """Show what is selected as large as possible; in a volume, in the slices through its middle."""
        places = selected_places(self._workspace)
        if places:
            self.canvas.show_part(part_around(np.concatenate(places), self.canvas, self._workspace.slices))

    def add_circle(self) -> None:
        """Add a circle in the middle of the visible part."""
        seen = self.canvas.view.viewRect()
        if self.canvas.shape is None:
            return
        rows, cols = self.canvas.shape
        row = min(max(seen.center().y(), 0.0), rows - 1.0)
        col = min(max(seen.center().x(), 0.0), cols - 1.0)
        radius = max(4.0, _MIDDLE_FRACTION * min(seen.width(), seen.height(), rows, cols))
        volume = self.canvas.drawn.volume
        name = tr("add circle") if volume is None else tr("add sphere")
        shape = _round_shape(volume, self.canvas.placed((row, col)), radius)
        self._session.edit(name, lambda document: edits.add_shape(document, shape))
        self._session.select(len(self._session.document.shapes) - 1)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle keys for the selected shape."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and self._wants(event):
            event.accept()
            return True
        if event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent) and self._take_key(event):
            return True
        return super().eventFilter(watched, event)

    def _draw(self) -> None:
        self.canvas.draw(self._workspace.other_result.near(self._session.scene))
        self.strip.legend.refresh()

    def _follow_contours(self) -> None:
        """Contours that are not visible cannot be selected."""
        self._review.rejected_seen = bool(self.canvas.layers.contours.chosen["rejected"])

    def _wants(self, event: QKeyEvent) -> bool:
        """Whether a key that is also a shortcut of the window belongs to the draft or changes a size."""
        tool = self.canvas.hold.tool
        if tool is None:
            return False
        if event.key() in _SIZES:
            return tool.sized or self._session.selected is not None
        return event.key() == Qt.Key.Key_Backspace and tool.drafting

    def _take_key(self, event: QKeyEvent) -> bool:
        key = Qt.Key(event.key())
        tool = self.canvas.hold.tool
        keyed, held = self.crosshair.at is not None, event.modifiers()
        ends = not keyed or held & Qt.KeyboardModifier.ControlModifier or key == Qt.Key.Key_Backspace
        if tool is not None and tool.drafting and key in _DRAFT_KEYS and ends:
            (tool.take_back if key == Qt.Key.Key_Backspace else tool.finish)()
            return True
        if key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.canvas.hold.set_modifiers(held)
            (self.crosshair.enter if keyed else self.crosshair.show)()
            return True
        factor = 10.0 if held & Qt.KeyboardModifier.ShiftModifier else 1.0
        index = self._session.selected
        if key in _ARROWS:
            row, col = _ARROWS[key]
            if keyed:
                self.crosshair.move(*self.canvas.toward(factor * row, factor * col))
            elif index is None:
                self.canvas.pan(_PAN * col, _PAN * row)
            else:
                name = tr("move {shape}").format(shape=from_core(self._session.document.shapes[index].title))
                by = _displaced(self._session.scene, self.canvas.toward(factor * row, factor * col))
                self._session.edit(name, lambda document: edits.move_shape(document, index, by), f"nudge {index}")
            return True
        if key in _SIZES and index is not None:
            self.grow(index, _SIZES[key])
            return True
        if key in _SIZES and tool is not None and tool.sized:
            tool.resize(_SIZES[key])
            return True
        return False

    def grow(self, index: int, by: float) -> None:
        """Make a shape larger, or smaller for `by` below 0."""
        shape = self._session.document.shapes[index]
        verb = tr("resize {shape}") if shape.outline.size else tr("change {shape}")
        name, resized = verb.format(shape=from_core(shape.title)), shape.resized(by)
        self._session.edit(name, lambda document: edits.replace_shape(document, index, resized), f"grow {index}")


def _displaced(scene: Scene, by: Position) -> Place:
    """A displacement on the canvas as one in the image or in the volume."""
    return by if scene.slices is None else scene.slices.current.along(by)


def _grid_around(canvas: QWidget) -> QGridLayout:
    """A grid in which the canvas takes the first column, as high as two views next to it."""
    grid = QGridLayout()
    grid.setSpacing(2)
    grid.addWidget(canvas, 0, 0, 2, 1)
    return grid


def _round_shape(volume: Image | None, center: Place, radius: float) -> Shape:
    """A circle in an image, a sphere in a volume."""
    return Circle(center, radius) if volume is None else Sphere.round(center, radius, volume.spacing)
