"""The canvas: a view of the image on which the pointer works with tools."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication

from app.model.text.language import tr
from app.views.canvas.image_view import ImageView
from app.views.canvas.layers.layer import Requests
from app.views.canvas.tools.tool import Tool, ToolInUse
from cpm_core.numerics import Position

ZOOM = 1.2


class Panning:
    """A drag that moves the image; one of the right button begins only when the pointer has moved."""

    def __init__(self) -> None:
        self._from: QPointF | None = None
        self._still = False

    @property
    def active(self) -> bool:
        """Whether the button is down."""
        return self._from is not None

    def begin(self, at: QPointF, at_once: bool) -> None:
        """Begin at a point of the widget."""
        self._from, self._still = at, not at_once

    def move(self, to: QPointF) -> QPointF:
        """By how much to pan [px of the screen]."""
        assert self._from is not None
        moved = self._from - to
        if self._still and moved.manhattanLength() < QApplication.startDragDistance():
            return QPointF()
        self._from, self._still = to, False
        return moved

    def end(self) -> bool:
        """End, and tell whether it was a click."""
        self._from = None
        return self._still


class Wheel:
    """Counts whole notches of a wheel, which some devices turn in smaller parts."""

    def __init__(self) -> None:
        self._rest = 0.0

    def notches(self, event: QWheelEvent) -> int:
        """Notches toward the user since the last call."""
        turned = event.angleDelta().y() or event.angleDelta().x()  # some systems exchange them while Shift is held
        self._rest -= turned / 120.0
        whole = int(self._rest)
        self._rest -= whole
        return whole


class Canvas(ImageView):
    """Pans and zooms by the pointer, and passes the left button to the tool in use, at places in image or volume."""

    pointed = Signal(object)
    """Position (row, col) under the pointer, or None when it has left."""

    placed_at = Signal(object)
    """Place under the pointer, in the image or in the volume, in whichever view it is, or None when it has left."""

    taken = Signal()
    """A button of the pointer has been pressed, or there is another image: what keys do there is over."""

    slice_wanted = Signal(int)
    """The slice so many further along is wanted."""

    menu_wanted = Signal(object)
    """The right button was clicked at a point of the screen: QPoint."""

    def __init__(self, requests: Requests) -> None:
        super().__init__(requests)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAcceptDrops(False)
        self.setMinimumSize(320, 240)
        self.setAccessibleName(tr("Image"))
        self.hold = ToolInUse()
        self.led_by_keys = False
        self._pointer: Position | None = None
        self._over: QPointF | None = None
        self._panning = Panning()
        self._wheel = Wheel()
        self.view.sigRangeChanged.connect(self.point_again)

    def use_image(self) -> None:
        """Cancel what was begun on another image."""
        self.hold.cancel()
        self.taken.emit()
        super().use_image()
        self.point_again()

    def use(self, tool: Tool) -> None:
        """Pass the left button to another tool."""
        self.hold.take(tool)
        if self._pointer is not None:
            tool.here = self.here
            tool.hover(self.placed(self._pointer))
        self.viewport().setCursor(tool.cursor(self.placed((-1e9, -1e9)), 0.0))

    def move_to(self, at: Position) -> None:
        """Move the pointer, or the cross-hair, to a position."""
        self._pointer = at
        self.hold.move(self, at)
        self._report(at)

    def leave(self) -> None:
        """Take the pointer off the canvas."""
        self._pointer = self._over = None
        self.hold.leave()
        self._report(None)

    def point_again(self) -> None:
        """The pointer rests, and another place of the image, of a slice or of another image has moved under it."""
        if self._over is not None and not self.led_by_keys:
            self._pointer = self.position(self._over)
            self._report(self._pointer)

    def _report(self, at: Position | None) -> None:
        self.pointed.emit(at)
        self.placed_at.emit(None if at is None else self.placed(at))

    # Called by Qt

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin a gesture or a pan."""
        event.accept()
        self.taken.emit()
        if event.button() == Qt.MouseButton.LeftButton and self.shape is not None:
            self.hold.set_modifiers(event.modifiers())
            self.hold.press(self, self.position(event.position()))
        elif event.button() in (Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton):
            self._panning.begin(event.position(), at_once=event.button() == Qt.MouseButton.MiddleButton)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Continue it, or report the position of the pointer."""
        event.accept()
        self._over = event.position()
        at = self.position(self._over)
        if self._panning.active:
            moved = self._panning.move(event.position())
            if not moved.isNull():
                self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)
                self.pan(moved.x(), moved.y())
                self._report(at)
        elif not self.led_by_keys:
            self.hold.set_modifiers(event.modifiers())
            self.move_to(at)

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End it."""
        event.accept()
        if event.button() == Qt.MouseButton.LeftButton and self.hold.dragging:
            self.hold.release()
        elif self._panning.active:
            if self._panning.end() and event.button() == Qt.MouseButton.RightButton and not self.hold.dragging:
                self.menu_wanted.emit(event.globalPosition().toPoint())
            self.hold.show_cursor(self, self.position(event.position()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Treat the second click like any other."""
        self.mousePressEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom around the pointer; with Shift go through the slices of a volume."""
        event.accept()
        if event.modifiers() & Qt.KeyboardModifier.ShiftModifier and self._scene.slices is not None:
            self.slice_wanted.emit(self._wheel.notches(event))
        else:
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
        if self.hold.dragging and event.reason() == Qt.FocusReason.ActiveWindowFocusReason:
            self.hold.cancel()
        super().focusOutEvent(event)
