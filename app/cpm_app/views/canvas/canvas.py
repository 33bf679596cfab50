"""The canvas: a view of the image on which the pointer works with the tool in use."""

from __future__ import annotations

import math
from collections.abc import Callable

from PySide6.QtCore import QEvent, QObject, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication

from cpm_app.model.text.language import tr
from cpm_app.views.canvas.image_view import ImageView
from cpm_app.views.layers.layer import Requests
from cpm_app.views.tools.tool import Tool
from cpm_core.numerics import Position

ZOOM = 1.2
"""Magnification by one notch of the wheel."""


class Wheel:
    """Counts whole notches of a wheel; some devices report fractions of one."""

    def __init__(self) -> None:
        self._rest = 0.0

    def notches(self, event: QWheelEvent) -> int:
        """Count the whole notches toward the user since the last call."""
        turned = event.angleDelta().y() or event.angleDelta().x()  # some systems exchange them while Shift is held
        self._rest -= turned / 120.0
        whole = int(self._rest)
        self._rest -= whole
        return whole


class ToolInUse:
    """Dispatches the pointer to the tool in use, or to `grip`, which moves the handles of the selected shape."""

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
        """Switch to another tool."""
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
        """Find the tool that a press here goes to: the handle tool over a handle, otherwise the tool in use."""
        self.tool.here = self._grip.here = view.here
        grips = not self.tool.drafting and self._grip.grips(view.placed(at), view.reach())
        return self._grip if grips else self.tool

    def show_cursor(self, view: ImageView, at: Position) -> None:
        """Show the cursor for a press at a position."""
        view.viewport().setCursor(self.at(view, at).cursor(view.placed(at), view.reach()))


class Pointer(QObject):
    """Handles the mouse buttons in a view: the left one works with the tool in use, the others drag.

    A right-button drag begins once the pointer has moved; a right click without a drag opens a menu.
    """

    moved = Signal(object)
    """Position (row, col) of the pointer; not emitted while another button drags."""
    dragged = Signal(object, object)
    """Drag with another button: QMouseEvent, and the distance to pan [px of the screen], QPointF."""
    menu_wanted = Signal(object)
    """The right button was clicked at a point of the screen: QPoint."""
    doubled = Signal()
    """The left button was clicked a second time, and the tool has handled it."""

    def __init__(self, view: ImageView, canvas: Canvas) -> None:
        super().__init__(view)
        self._view, self._canvas = view, canvas
        self.over: QPointF | None = None
        """Point of the view under the pointer; None when it has left."""
        self._from: QPointF | None = None
        self._still = self._twice = False
        self._does: dict[QEvent.Type, Callable[[QMouseEvent], None]] = {
            QEvent.Type.MouseButtonPress: self._press,
            QEvent.Type.MouseButtonDblClick: self._press,
            QEvent.Type.MouseMove: self._move,
            QEvent.Type.MouseButtonRelease: self._release,
        }
        view.viewport().installEventFilter(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Handle the events of the pointer."""
        if isinstance(event, QMouseEvent) and event.type() in self._does:
            event.accept()
            self._does[event.type()](event)
            return True
        canvas = self._canvas
        if event.type() == QEvent.Type.Leave and not (canvas.led_by_keys or canvas.hold.dragging):
            canvas.leave()
        return False

    def _press(self, event: QMouseEvent) -> None:
        """Begin a gesture or a drag."""
        canvas = self._canvas
        canvas.taken.emit()
        canvas.setFocus()
        if event.button() == Qt.MouseButton.LeftButton and self._view.shape is not None:
            canvas.hold.set_modifiers(event.modifiers())
            self._twice = event.type() == QEvent.Type.MouseButtonDblClick
            canvas.hold.press(self._view, self._view.position(event.position()))
        elif event.button() in (Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton):
            self._from, self._still = event.position(), event.button() == Qt.MouseButton.RightButton
            self.dragged.emit(event, QPointF())

    def _move(self, event: QMouseEvent) -> None:
        """Continue a drag, or report the position of the pointer."""
        self.over = event.position()
        if self._from is not None:
            by = self._from - event.position()
            if not self._still or by.manhattanLength() >= QApplication.startDragDistance():
                self._from, self._still = event.position(), False
                self._view.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)
                self.dragged.emit(event, by)
        elif not self._canvas.led_by_keys:
            self._canvas.hold.set_modifiers(event.modifiers())
            self.moved.emit(self._view.position(event.position()))

    def _release(self, event: QMouseEvent) -> None:
        """End a gesture or a drag."""
        hold = self._canvas.hold
        if event.button() == Qt.MouseButton.LeftButton and hold.dragging:
            hold.release()
            if self._twice:
                self.doubled.emit()
        elif self._from is not None:
            self._from = None
            if self._still and event.button() == Qt.MouseButton.RightButton and not hold.dragging:
                self.menu_wanted.emit(event.globalPosition().toPoint())
            hold.show_cursor(self._view, self._view.position(event.position()))


class Canvas(ImageView):
    """Shows the image, or the current slice; the middle and the right button pan, the wheel zooms."""

    pointed = Signal(object)
    """Position (row, col) under the pointer, or None when it has left."""

    placed_at = Signal(object)
    """Place under the pointer in the image or volume, in any view, or None when it has left."""

    taken = Signal()
    """A mouse button was pressed, or another image opened: control by keys ends."""

    slice_wanted = Signal(int)
    """Number of slices by which the user wants to move on."""

    hold: ToolInUse
    """Receiver of the gestures, set once the tools have been created for the layers of this canvas."""

    def __init__(self, requests: Requests) -> None:
        super().__init__(requests)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAcceptDrops(False)
        self.setMinimumSize(240, 160)
        self.setAccessibleName(tr("Image"))
        self.led_by_keys = False
        self._pointer: Position | None = None
        self._wheel = Wheel()
        self.pointer = Pointer(self, self)
        self.pointer.moved.connect(self.move_to)
        self.pointer.dragged.connect(lambda _, by: self.pan(by.x(), by.y()))
        self.view.sigRangeChanged.connect(self.point_again)

    def use_image(self) -> None:
        """Cancel gestures begun on the previous image."""
        self.hold.cancel()
        self.taken.emit()
        super().use_image()
        self.point_again()

    def use(self, tool: Tool) -> None:
        """Give the left button to another tool."""
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
        """Handle the pointer leaving the canvas."""
        self._pointer = self.pointer.over = None
        self.hold.tool.put_away()
        self._report(None)

    def point_again(self) -> None:
        """Report the place under a resting pointer again, after the image has moved or changed under it."""
        if self.pointer.over is not None and not self.led_by_keys:
            self._pointer = self.position(self.pointer.over)
            self._report(self._pointer)

    def _report(self, at: Position | None) -> None:
        self.pointed.emit(at)
        self.placed_at.emit(None if at is None else self.placed(at))

    # Called by Qt

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Zoom around the pointer; with Shift, step through the slices of a volume or resize the tool."""
        event.accept()
        if event.modifiers() & Qt.KeyboardModifier.ShiftModifier and self.here is not None:
            self.slice_wanted.emit(self._wheel.notches(event))
        elif event.modifiers() & Qt.KeyboardModifier.ShiftModifier and self.hold.tool.sized:
            notches = self._wheel.notches(event)
            for _ in range(abs(notches)):
                self.hold.tool.resize(-math.copysign(1.0, notches))
        else:
            self.zoom(ZOOM ** (event.angleDelta().y() / 120.0), event.position())

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Show the effect of Shift on the tool; leave keys to the window."""
        self._use_shift(event, event.modifiers() | Qt.KeyboardModifier.ShiftModifier)

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Show the effect of releasing Shift; leave keys to the window."""
        self._use_shift(event, event.modifiers() & ~Qt.KeyboardModifier.ShiftModifier)

    def _use_shift(self, event: QKeyEvent, modifiers: Qt.KeyboardModifier) -> None:
        event.ignore()
        if event.key() == Qt.Key.Key_Shift and self._pointer is not None and not self.led_by_keys:
            self.hold.set_modifiers(modifiers)
            self.hold.move(self, self._pointer)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Cancel the drag when the window loses the focus."""
        if self.hold.dragging and event.reason() == Qt.FocusReason.ActiveWindowFocusReason:
            self.hold.cancel()
        super().focusOutEvent(event)
