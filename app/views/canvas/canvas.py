"""The canvas: a view of the image on which the pointer works with the tool in use."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication

from app.model.text.language import tr
from app.views.canvas.image_view import ImageView
from app.views.canvas.layers.layer import Requests
from app.views.canvas.tools.tool import Tool
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


class ToolInUse:
    """Passes what the pointer does to the tool in use, or to `grip`, which moves handles of what is selected."""

    def __init__(self, tool: Tool, grip: Tool) -> None:
        self.tool, self._grip = tool, grip
        self._dragged: Tool | None = None

    @property
    def gesturing(self) -> bool:
        """Whether a tool has an unfinished gesture or draft."""
        return self.dragging or self.tool.drafting

    @property
    def dragging(self) -> bool:
        """Whether the button is down for a tool."""
        return self._dragged is not None

    def cancel(self) -> None:
        """Cancel the gesture or draft of the tool."""
        if self.gesturing:
            tool, self._dragged = self._dragged or self.tool, None
            tool.cancel()

    def take(self, tool: Tool) -> None:
        """Use another tool."""
        if self.dragging or not self.tool.lasting:
            self.cancel()
        self.tool.put_away()
        self.tool.set_in_use(False)
        self.tool = tool
        tool.set_in_use(True)

    def press(self, view: ImageView, at: Position, reach: float | None = None) -> None:
        """Press the left button over a position; `reach` is the tolerance for hits [px of the image]."""
        self._dragged = self.at(view, at)
        self._dragged.press(view.placed(at), view.reach() if reach is None else reach)

    def move(self, view: ImageView, at: Position) -> None:
        """Move the pointer to a position."""
        tool = self._dragged or self.tool
        tool.here = view.here
        if self.dragging:
            tool.drag(view.placed(at))
        else:
            tool.hover(view.placed(at))
            self.show_cursor(view, at)

    def release(self) -> None:
        """Release the left button."""
        if self._dragged is not None:
            tool, self._dragged = self._dragged, None
            tool.release()

    def set_modifiers(self, modifiers: Qt.KeyboardModifier) -> None:
        """Pass the modifier keys that are held to the tool."""
        (self._dragged or self.tool).modifiers = modifiers

    def at(self, view: ImageView, at: Position) -> Tool:
        """The tool that receives a press: one that takes hold of a handle has priority over the tool in use."""
        self.tool.here = self._grip.here = view.here
        grips = not self.tool.drafting and self._grip.grips(view.placed(at), view.reach())
        return self._grip if grips else self.tool

    def show_cursor(self, view: ImageView, at: Position) -> None:
        """Show what a press at a position would do."""
        view.viewport().setCursor(self.at(view, at).cursor(view.placed(at), view.reach()))


class PointedView(ImageView):
    """Passes the left button to the tool in use, and the drags of the others to `drag`."""

    menu_wanted = Signal(object)
    """The right button was clicked at a point of the screen: QPoint."""

    def __init__(self, requests: Requests | None = None, original: ImageView | None = None) -> None:
        super().__init__(requests, original)
        self._panning = Panning()
        self._wheel = Wheel()

    @property
    def main(self) -> Canvas:
        """The canvas, which holds the tool."""
        raise NotImplementedError

    def move_to(self, at: Position) -> None:
        """Move the pointer, or the cross-hair, to a position."""
        raise NotImplementedError

    def drag(self, event: QMouseEvent, moved: QPointF) -> None:
        """Handle a drag of the middle or the right button; by default it moves the image."""
        self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)
        self.pan(moved.x(), moved.y())

    # Called by Qt

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin a gesture or a drag."""
        event.accept()
        self.main.taken.emit()
        self.main.setFocus()
        if event.button() == Qt.MouseButton.LeftButton and self.shape is not None:
            self.main.hold.set_modifiers(event.modifiers())
            self.main.hold.press(self, self.position(event.position()))
        elif event.button() in (Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton):
            self._panning.begin(event.position(), at_once=event.button() == Qt.MouseButton.MiddleButton)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Continue it, or report the position of the pointer."""
        event.accept()
        if self._panning.active:
            moved = self._panning.move(event.position())
            if not moved.isNull():
                self.drag(event, moved)
        elif not self.main.led_by_keys:
            self.main.hold.set_modifiers(event.modifiers())
            self.move_to(self.position(event.position()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End it."""
        event.accept()
        hold = self.main.hold
        if event.button() == Qt.MouseButton.LeftButton and hold.dragging:
            hold.release()
        elif self._panning.active:
            if self._panning.end() and event.button() == Qt.MouseButton.RightButton and not hold.dragging:
                self.menu_wanted.emit(event.globalPosition().toPoint())
            hold.show_cursor(self, self.position(event.position()))

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Treat the second click like any other."""
        self.mousePressEvent(event)

    def leaveEvent(self, event: QEvent) -> None:
        """Report that the pointer has left."""
        if not self.main.led_by_keys and not self.main.hold.dragging:
            self.main.leave()
        super().leaveEvent(event)


class Canvas(PointedView):
    """Shows the image, or the slice that is worked on; the middle and the right button pan, the wheel zooms."""

    pointed = Signal(object)
    """Position (row, col) under the pointer, or None when it has left."""

    placed_at = Signal(object)
    """Place under the pointer, in the image or in the volume, in whichever view it is, or None when it has left."""

    taken = Signal()
    """A button of the pointer has been pressed, or there is another image: what keys do there is over."""

    slice_wanted = Signal(int)
    """The slice so many further along is wanted."""

    hold: ToolInUse
    """What receives the gestures; the tools are made for the layers of a canvas."""

    def __init__(self, requests: Requests) -> None:
        super().__init__(requests)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAcceptDrops(False)
        self.setMinimumSize(320, 240)
        self.setAccessibleName(tr("Image"))
        self.led_by_keys = False
        self._pointer: Position | None = None
        self._over: QPointF | None = None
        self.view.sigRangeChanged.connect(self.point_again)

    @property
    def main(self) -> Canvas:
        """Itself."""
        return self

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
        self.hold.tool.put_away()
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

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Remember where the pointer is."""
        self._over = event.position()
        super().mouseMoveEvent(event)

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom around the pointer; with Shift go through the slices of a volume."""
        event.accept()
        if event.modifiers() & Qt.KeyboardModifier.ShiftModifier and self.here is not None:
            self.slice_wanted.emit(self._wheel.notches(event))
        else:
            self.zoom(ZOOM ** (event.angleDelta().y() / 120.0), event.position())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Leave keys to the window."""
        event.ignore()

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Leave keys to the window."""
        event.ignore()

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Cancel the drag when the window loses the focus."""
        if self.hold.dragging and event.reason() == Qt.FocusReason.ActiveWindowFocusReason:
            self.hold.cancel()
        super().focusOutEvent(event)
