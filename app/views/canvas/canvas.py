"""The canvas: a view of the image on which the pointer works with tools."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QWheelEvent

from app.model.text.language import tr
from app.views.canvas.image_view import ImageView
from app.views.canvas.layers.layer import Requests
from app.views.canvas.tools.tool import Tool
from cpm_core.numerics.types import Position

REACH = 8.0
"""Distance from a line or handle within which the pointer takes hold of it [px of the screen]."""

ZOOM = 1.2


class Canvas(ImageView):
    """Pans and zooms by the pointer, and passes the left button to the tool in use."""

    pointed = Signal(object)
    """Position (row, col) under the pointer, or None when it has left."""

    taken = Signal()
    """A button of the pointer has been pressed."""

    def __init__(self, requests: Requests) -> None:
        super().__init__(requests)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAcceptDrops(False)
        self.setMinimumSize(320, 240)
        self.setAccessibleName(tr("Image"))
        self.tool: Tool | None = None
        self.grip: Tool | None = None
        self.led_by_keys = False
        self._dragged: Tool | None = None
        self._pointer: Position | None = None
        self._over: QPointF | None = None
        self._panned_from: QPointF | None = None
        self.view.sigRangeChanged.connect(self._point_again)

    @property
    def gesturing(self) -> bool:
        """Whether a tool has an unfinished gesture or draft."""
        return self._dragged is not None or (self.tool is not None and self.tool.drafting)

    @property
    def dragging(self) -> bool:
        """Whether the button is down for a tool."""
        return self._dragged is not None

    def use_image(self) -> None:
        """Cancel what was begun on another image."""
        self.cancel()
        super().use_image()
        self._point_again()

    def cancel(self) -> None:
        """Cancel the gesture or draft of the tool."""
        tool = self._dragged or (self.tool if self.gesturing else None)
        self._dragged = None
        if tool is not None:
            tool.cancel()

    def use(self, tool: Tool) -> None:
        """Pass the left button to another tool."""
        if self.dragging or not (self.tool is not None and self.tool.lasting):
            self.cancel()
        if self.tool is not None:
            self.tool.put_away()
            self.tool.set_in_use(False)
        self.tool = tool
        tool.set_in_use(True)
        if self._pointer is not None:
            tool.hover(self._pointer)
        self.viewport().setCursor(tool.cursor((-1e9, -1e9), 0.0))

    # Common to pointer and keys

    def press_at(self, at: Position, reach: float | None = None) -> None:
        """Press the left button over a position; `reach` is the tolerance for hits [px of the image]."""
        if self.tool is not None and self.shape is not None:
            self._dragged = self._tool_at(at)
            self._dragged.press(at, self._reach() if reach is None else reach)

    def lead_to(self, at: Position) -> None:
        """Move the pointer to a position."""
        self._pointer = at
        if self._dragged is not None:
            self._dragged.drag(at)
        elif self.tool is not None:
            self.tool.hover(at)
            self.viewport().setCursor(self._tool_at(at).cursor(at, self._reach()))
        self.pointed.emit(at)

    def let_go(self) -> None:
        """Release the left button."""
        if self._dragged is not None:
            tool, self._dragged = self._dragged, None
            tool.release()

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """Pass the modifier keys that are held to the tool; they may constrain the shape."""
        tool = self._dragged or self.tool
        if tool is not None:
            tool.bend(modifiers)

    def leave(self) -> None:
        """Take the pointer off the canvas."""
        self._pointer = self._over = None
        if self.tool is not None:
            self.tool.put_away()
        self.pointed.emit(None)

    def grips(self, at: Position) -> bool:
        """Whether a handle at a position has priority over the tool in use."""
        return self._tool_at(at) is not self.tool

    # Called by Qt

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin a gesture or a pan."""
        event.accept()
        self.taken.emit()
        if event.button() == Qt.MouseButton.LeftButton:
            self.bend(event.modifiers())
            self.press_at(self.position(event.position()))
        elif event.button() in (Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton):
            self._panned_from = event.position()
            self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Continue it, or report the position of the pointer."""
        event.accept()
        self._over = event.position()
        at = self.position(self._over)
        if self._panned_from is not None:
            moved = self._panned_from - event.position()
            self._panned_from = event.position()
            self.pan(moved.x(), moved.y())
            self.pointed.emit(at)
        elif not self.led_by_keys:
            self.bend(event.modifiers())
            self.lead_to(at)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End it."""
        event.accept()
        if event.button() == Qt.MouseButton.LeftButton and self._dragged is not None:
            self.let_go()
        elif self._panned_from is not None:
            self._panned_from = None
            if self.tool is not None:
                at = self.position(event.position())
                self.viewport().setCursor(self._tool_at(at).cursor(at, self._reach()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Treat the second click like any other."""
        self.mousePressEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom around the pointer."""
        event.accept()
        self.zoom(ZOOM ** (event.angleDelta().y() / 120.0), event.position())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Leave keys to the window."""
        event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Leave keys to the window."""
        event.ignore()

    def leaveEvent(self, event: QEvent) -> None:
        """Report that the pointer has left."""
        if not self.led_by_keys:
            self.leave()
        super().leaveEvent(event)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Cancel the drag when the window loses the focus."""
        if self._dragged is not None and event.reason() == Qt.FocusReason.ActiveWindowFocusReason:
            self.cancel()
        super().focusOutEvent(event)

    def _tool_at(self, at: Position) -> Tool:
        """The tool that receives a press: one that takes hold of a handle has priority over the tool in use."""
        assert self.tool is not None
        if self.grip is not None and not self.tool.drafting and self.grip.grips(at, self._reach()):
            return self.grip
        return self.tool

    def _point_again(self) -> None:
        """The pointer rests, and another place of the image, or of another image, has moved under it."""
        if self._over is not None and not self.led_by_keys:
            self._pointer = self.position(self._over)
            self.pointed.emit(self._pointer)

    def _reach(self) -> float:
        return REACH * float(self.view.viewPixelSize()[0])
