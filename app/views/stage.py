"""The stage: the canvas with the message bar and the hint upon it, following the session."""

from __future__ import annotations

import numpy as np
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeyEvent
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from app.model import edits
from app.model.shades import Shades
from app.model.shapes import SMALLEST_RADIUS, Circle, describe
from app.session.messages import Overlays, Snapshot
from app.session.session import Session
from app.views.canvas import Canvas
from app.views.message_bar import MessageBar
from app.views.path_tool import BARRIER, REGION, STROKE, PathTool
from app.views.tools import CircleTool, PointTool, SelectTool, Tool
from cpm_core.image import Image
from cpm_core.result import Result

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


class Stage(QWidget):
    """Draws what the session tells and lets the tools work on it."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self.canvas = Canvas()
        self.messages = MessageBar(self.canvas)
        self.hint = QLabel(self.canvas)
        self.hint.setObjectName("hint")
        self.hint.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.hint.hide()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addWidget(self.canvas, 1)
        self.canvas.grip = select = SelectTool(session)
        tools: tuple[Tool, ...] = (
            select,
            CircleTool(session),
            PointTool(session),
            *(PathTool(session, kind, self._show_draft) for kind in (STROKE, REGION, BARRIER)),
        )
        self._hint = ""
        self._tools = {tool.name: tool for tool in tools}
        self._visible = {"edge_map": False, "field": False}
        self._drawn: tuple[object, ...] = ()
        self.canvas.installEventFilter(self)
        self.use_tool("circle")
        session.image_changed.connect(self._show_image)
        session.document_changed.connect(self._show_drawing)
        session.status_changed.connect(self._show_drawing)
        session.snapshot_changed.connect(self._show_snapshot)
        session.contours_changed.connect(self._show_contours)
        session.overlays_changed.connect(self._show_overlays)
        session.sown_changed.connect(self.canvas.drawing.show_sown)
        session.said.connect(self.messages.say)

    def use_tool(self, name: str) -> None:
        """Change the tool; who is about to draw is done with what was selected, whose handles would be in the way."""
        self.canvas.use(self._tools[name])
        if name != "select":
            self._session.select(None)
        self.show_hint(self._hint)

    def show_layer(self, name: str, shown: bool) -> None:
        """Show or hide a layer; overlays are asked for only while they are seen."""
        layers = self.canvas
        if name in self._visible:
            self._visible[name] = shown
            self._session.want_overlays(**self._visible)
            if not shown:
                (layers.edge_map if name == "edge_map" else layers.field).show(None)
        elif name == "particles":
            layers.particles.set_visible(shown)
        elif name == "contours":
            layers.contours.set_visible(shown)
        else:
            layers.drawing.set_visible(shown)

    def escape(self) -> None:
        """Give up what is being drawn; when nothing is, dismiss the message and select nothing."""
        if self.canvas.gesturing:
            self.canvas.cancel()
        else:
            self.messages.hide()
            self._session.select(None)

    def show_hint(self, text: str) -> None:
        """Say what to do next, at the foot of the canvas; a tool that wants to say something comes first."""
        self._hint = text
        tool = self.canvas.tool
        text = (tool.advice if tool is not None and self._session.document.image is not None else "") or text
        if self.hint.text() != text or self.hint.isHidden() == bool(text):
            self.hint.setText(text)
            self.hint.setVisible(bool(text))
            self._place_hint()

    def add_circle(self) -> None:
        """Draw a circle in the middle of what is seen."""
        seen = self.canvas.view.viewRect()
        image = self._session.document.image
        if image is None:
            return
        rows, cols = image.shape
        row = min(max(seen.center().y(), 0.0), rows - 1.0)
        col = min(max(seen.center().x(), 0.0), cols - 1.0)
        circle = Circle((row, col), max(4.0, _MIDDLE_FRACTION * min(seen.width(), seen.height(), rows, cols)))
        self._session.edit("add circle", lambda document: edits.add_shape(document, circle))
        self._session.select(len(self._session.document.shapes) - 1)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Keys for the selected shape, and the places of bar and hint when the canvas changes its size."""
        if event.type() == QEvent.Type.Resize:
            self.messages.place()
            self._place_hint()
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and self._wants(event):
            event.accept()
            return True
        if event.type() == QEvent.Type.KeyPress and isinstance(event, QKeyEvent) and self._take_key(event):
            return True
        return super().eventFilter(watched, event)

    def _wants(self, event: QKeyEvent) -> bool:
        """Whether a key that is a shortcut of the window belongs to what is being drawn."""
        tool = self.canvas.tool
        return event.key() == Qt.Key.Key_Backspace and tool is not None and tool.drafting

    def _take_key(self, event: QKeyEvent) -> bool:
        key = Qt.Key(event.key())
        tool = self.canvas.tool
        if tool is not None and tool.drafting and key in _DRAFT_KEYS:
            (tool.take_back if key == Qt.Key.Key_Backspace else tool.finish)()
            return True
        factor = 10.0 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1.0
        index = self._session.selected
        if key in _ARROWS:
            row, col = _ARROWS[key]
            if index is None:
                self.canvas.pan(_PAN * col, _PAN * row)
            else:
                name = f"move {describe(self._session.document.shapes[index])}"
                by = (factor * row, factor * col)
                self._session.edit(name, lambda document: edits.move_shape(document, index, by), f"nudge {index}")
            return True
        if key in _SIZES and index is not None:
            self._grow(index, _SIZES[key])
            return True
        return False

    def _grow(self, index: int, by: float) -> None:
        shape = self._session.document.shapes[index]
        if isinstance(shape, Circle):
            grown = Circle(shape.center, max(shape.radius + by, SMALLEST_RADIUS))
            self._session.edit(
                "resize circle", lambda document: edits.replace_shape(document, index, grown), f"grow {index}"
            )

    def _show_image(self, _: Image, shades: Shades) -> None:
        self.canvas.show_image(shades)
        self.canvas.edge_map.show(None)
        self.canvas.field.show(None)

    def _show_drawing(self, *_: object) -> None:
        session = self._session
        wanted = (session.document.shapes, session.selected, session.status.moved)
        if wanted != self._drawn:
            self._drawn = wanted
            self.canvas.drawing.show(session.document, session.selected, session.status.moved)

    def _show_draft(self) -> None:
        tool = self.canvas.tool
        if isinstance(tool, PathTool):
            self.canvas.drawing.show_draft(tool.corners, tool.path, tool.kind.colour, tool.kind.closed)
        self.show_hint(self._hint)

    def _show_snapshot(self, snapshot: Snapshot | None) -> None:
        if snapshot is None:
            self.canvas.particles.show(np.empty((0, 2)), np.empty(0, dtype=bool))
        else:
            self.canvas.particles.show(snapshot.position, snapshot.resting)

    def _show_contours(self, result: Result | None) -> None:
        self.canvas.contours.show(result.contours if result else (), result.bridges if result else ())

    def _show_overlays(self, overlays: Overlays) -> None:
        self.canvas.edge_map.show(overlays.edge_map if self._visible["edge_map"] else None)
        self.canvas.field.show(overlays.field if self._visible["field"] else None)

    def _place_hint(self) -> None:
        self.hint.adjustSize()
        size = self.canvas.size()
        self.hint.move((size.width() - self.hint.width()) // 2, size.height() - self.hint.height() - 14)
