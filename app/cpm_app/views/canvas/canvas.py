"""The canvas: a view of the image on which the pointer works with the tool in use."""

from __future__ import annotations

import math

from PySide6.QtCore import QEvent, QPointF, Qt, Signal
from PySide6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QApplication

from cpm_app.model.text.language import tr
from cpm_app.session.session import Session
from cpm_app.views.canvas.image_view import ImageView
from cpm_app.views.tools.tool import Tool
from cpm_core.numerics import Position

WHEEL_ZOOM_FACTOR = 1.2
"""Magnification by one notch of the wheel."""

_MODIFIERS_BY_KEY: dict[int, Qt.KeyboardModifier] = {
    Qt.Key.Key_Shift: Qt.KeyboardModifier.ShiftModifier,
    Qt.Key.Key_Control: Qt.KeyboardModifier.ControlModifier,
}
"""Modifiers that change what a press does, by their keys."""


def _modifier_of(event: QKeyEvent) -> Qt.KeyboardModifier:
    return _MODIFIERS_BY_KEY.get(event.key(), Qt.KeyboardModifier.NoModifier)


class WheelNotchCounter:
    """Counts whole notches of a wheel; some devices report fractions of one."""

    def __init__(self) -> None:
        self._rest = 0.0

    def count_notches(self, event: QWheelEvent) -> int:
        """Count the whole notches toward the user since the last call."""
        turned = event.angleDelta().y() or event.angleDelta().x()  # some systems exchange them while Shift is held
        self._rest -= turned / 120.0
        whole = int(self._rest)
        self._rest -= whole
        return whole


class ToolDispatcher:
    """Dispatches the pointer to the tool in use, or to `handle_tool`, which moves the handles of the selected shape."""

    def __init__(self, tool: Tool, handle_tool: Tool) -> None:
        self.tool, self._handle_tool = tool, handle_tool
        self._pressed_tool: Tool | None = None

    @property
    def is_gesturing(self) -> bool:
        """Whether a tool has an unfinished gesture or draft."""
        return self.is_dragging or self.tool.has_draft

    @property
    def is_dragging(self) -> bool:
        """Whether the button is down for a tool."""
        return self._pressed_tool is not None

    def cancel_gesture(self) -> None:
        """Cancel the gesture or draft of the tool."""
        if self.is_gesturing:
            tool, self._pressed_tool = self._pressed_tool or self.tool, None
            tool.cancel()

    def switch_tool(self, tool: Tool) -> None:
        """Switch to another tool."""
        if self.is_dragging or not self.tool.keeps_draft:
            self.cancel_gesture()
        self.tool.hide_marks()
        self.tool.set_in_use(False)
        self.tool = tool
        tool.set_in_use(True)

    def press_button(self, view: ImageView, at: Position, reach: float | None = None) -> None:
        """Press the left button over a position; `reach` is the tolerance for hits [px of the image]."""
        self._pressed_tool = tool = self.find_receiver(view, at)
        tool.reach = tool.reach if reach is None else reach
        tool.press(view.place_at(at))

    def move_pointer(self, view: ImageView, at: Position) -> None:
        """Move the pointer to a position."""
        if self._pressed_tool is not None:
            self._pressed_tool.current_slice = view.shown_slice
            self._pressed_tool.drag(view.place_at(at))
        else:
            self.find_receiver(view, at)
            self.tool.hover(view.place_at(at))
            self.show_cursor(view, at)

    def release_button(self) -> None:
        """Release the left button."""
        if self._pressed_tool is not None:
            tool, self._pressed_tool = self._pressed_tool, None
            tool.release()

    def set_modifiers(self, modifiers: Qt.KeyboardModifier) -> None:
        """Pass the modifier keys that are held to the tool."""
        (self._pressed_tool or self.tool).modifiers = modifiers

    def find_receiver(self, view: ImageView, at: Position) -> Tool:
        """Find the tool that a press here goes to: the handle tool over a handle, otherwise the tool in use."""
        for tool in (self.tool, self._handle_tool):
            tool.current_slice, tool.reach = view.shown_slice, view.hit_tolerance()
        over_handle = not self.tool.has_draft and self._handle_tool.has_handle_at(view.place_at(at))
        return self._handle_tool if over_handle else self.tool

    def show_cursor(self, view: ImageView, at: Position) -> None:
        """Show the cursor for a press at a position."""
        view.viewport().setCursor(self.find_receiver(view, at).cursor_at(view.place_at(at)))


class ToolView(ImageView):
    """A view in which the left button works with the tool in use, and the others drag.

    A right-button drag begins once the pointer has moved; a right click without a drag opens a menu.
    """

    menu_wanted = Signal(object)
    """The right button was clicked at a point of the screen: QPoint."""
    double_clicked = Signal()
    """The left button was clicked a second time, and the tool has handled it."""
    place_wanted = Signal(object)
    """Place of the volume that the user wants the slices through."""
    slice_step_wanted = Signal(int, int)
    """Axis, and the number of slices by which the user wants to move along it."""

    canvas: Canvas
    """The canvas itself, or that next to a side view; it has the keyboard focus and the dispatcher."""
    point_in_view: QPointF | None = None
    """Point of the view under the pointer; None when it has left."""
    _drag_origin: QPointF | None = None
    _is_still = _is_double_click = False

    def __init__(self, session: Session | None = None, original: ImageView | None = None) -> None:
        super().__init__(session, original)
        self._wheel = WheelNotchCounter()

    def move_pointer_to(self, at: Position) -> None:
        """Move the pointer to a position, unless another button drags."""
        raise NotImplementedError

    def drag_by(self, event: QMouseEvent, by: QPointF) -> None:
        """Move the cross of a volume with the right button; else pan by a distance [px of the screen]."""
        if self.shown_slice is not None and event.buttons() & Qt.MouseButton.RightButton:
            place = self.place_at(self.map_to_image(event.position()))
            self.place_wanted.emit(place)
            self.canvas.pointer_place_changed.emit(place)
        else:
            self.pan_by(by.x(), by.y())

    # Called by Qt

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Step through the slices of a volume, zoom around the pointer, or with Shift resize the tool."""
        event.accept()
        keys, tool, here = event.modifiers(), self.canvas.dispatcher.tool, self.shown_slice
        zooms = here is None or bool(keys & Qt.KeyboardModifier.ControlModifier) != self.canvas.wheel_zooms
        if keys & Qt.KeyboardModifier.ShiftModifier and tool.is_resizable:
            notches = self._wheel.count_notches(event)
            for _ in range(abs(notches)):
                tool.resize_by(-math.copysign(1.0, notches))
        elif zooms:
            self.zoom_by(WHEEL_ZOOM_FACTOR ** (event.angleDelta().y() / 120.0), event.position())
        elif here is not None:
            self.slice_step_wanted.emit(here.axis, self._wheel.count_notches(event))

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Begin a gesture or a drag."""
        canvas = self.canvas
        canvas.keyboard_interrupted.emit()
        canvas.setFocus()
        if event.button() == Qt.MouseButton.LeftButton and self.shape is not None:
            canvas.dispatcher.set_modifiers(event.modifiers())
            self._is_double_click = event.type() == QEvent.Type.MouseButtonDblClick
            canvas.dispatcher.press_button(self, self.map_to_image(event.position()))
        elif event.button() in (Qt.MouseButton.MiddleButton, Qt.MouseButton.RightButton):
            self._drag_origin, self._is_still = event.position(), event.button() == Qt.MouseButton.RightButton
            self.drag_by(event, QPointF())

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Begin the gesture of a second click."""
        self.mousePressEvent(event)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Continue a drag, or move the pointer."""
        self.point_in_view = event.position()
        if self._drag_origin is not None:
            by = self._drag_origin - event.position()
            if not self._is_still or by.manhattanLength() >= QApplication.startDragDistance():
                self._drag_origin, self._is_still = event.position(), False
                self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)
                self.drag_by(event, by)
        elif not self.canvas.is_led_by_keys:
            self.canvas.dispatcher.set_modifiers(event.modifiers())
            self.move_pointer_to(self.map_to_image(event.position()))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """End a gesture or a drag."""
        dispatcher = self.canvas.dispatcher
        if event.button() == Qt.MouseButton.LeftButton and dispatcher.is_dragging:
            dispatcher.release_button()
            if self._is_double_click:
                self.double_clicked.emit()
        elif self._drag_origin is not None:
            self._drag_origin = None
            if self._is_still and event.button() == Qt.MouseButton.RightButton and not dispatcher.is_dragging:
                self.menu_wanted.emit(event.globalPosition().toPoint())
            dispatcher.show_cursor(self, self.map_to_image(event.position()))

    def leaveEvent(self, event: QEvent) -> None:
        """Remove the pointer, unless keys lead it or it drags."""
        if not (self.canvas.is_led_by_keys or self.canvas.dispatcher.is_dragging):
            self.canvas.remove_pointer()


class Canvas(ToolView):
    """Shows the image, or the current slice; the middle button pans, in an image also the right one."""

    pointer_place_changed = Signal(object)
    """Place under the pointer in the image or volume, in any view, or None when it has left."""

    keyboard_interrupted = Signal()
    """A mouse button was pressed, or another image opened: control by keys ends."""

    dispatcher: ToolDispatcher
    """Receiver of the gestures, set once the tools have been created for the layers of this canvas."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAcceptDrops(False)
        self.setMinimumSize(240, 160)
        self.setAccessibleName(tr("Image"))
        self.is_led_by_keys = False
        self.wheel_zooms = False
        """Whether the wheel zooms in slices, and with Ctrl steps through them; else the other way round."""
        self._pointer: Position | None = None
        self.canvas = self
        self.view.sigRangeChanged.connect(self.report_resting_pointer)

    def on_image_changed(self) -> None:
        """Cancel gestures begun on the previous image."""
        self.dispatcher.cancel_gesture()
        self.keyboard_interrupted.emit()
        super().on_image_changed()
        self.report_resting_pointer()

    def use_tool(self, tool: Tool) -> None:
        """Give the left button to another tool."""
        self.dispatcher.switch_tool(tool)
        if self._pointer is not None:
            tool.current_slice = self.shown_slice
            tool.hover(self.place_at(self._pointer))
        self.viewport().setCursor(tool.cursor_at(self.place_at((-1e9, -1e9))))

    def move_pointer_to(self, at: Position) -> None:
        """Move the pointer, or the cross-hair, to a position."""
        self._pointer = at
        self.dispatcher.move_pointer(self, at)
        self._emit_pointer_place(at)

    def remove_pointer(self) -> None:
        """Handle the pointer leaving the canvas."""
        self._pointer = self.point_in_view = None
        self.dispatcher.tool.hide_marks()
        self._emit_pointer_place(None)

    def report_resting_pointer(self) -> None:
        """Report the place under a resting pointer again, after the image has moved or changed under it."""
        if self.point_in_view is not None and not self.is_led_by_keys:
            self._pointer = self.map_to_image(self.point_in_view)
            self._emit_pointer_place(self._pointer)

    def _emit_pointer_place(self, at: Position | None) -> None:
        self.pointer_place_changed.emit(None if at is None else self.place_at(at))

    # Called by Qt

    def keyPressEvent(self, event: QKeyEvent) -> None:
        """Show the effect of Shift or Ctrl on the tool; leave keys to the window."""
        self._apply_modifier_key(event, event.modifiers() | _modifier_of(event))

    def keyReleaseEvent(self, event: QKeyEvent) -> None:
        """Show the effect of releasing Shift or Ctrl; leave keys to the window."""
        self._apply_modifier_key(event, event.modifiers() & ~_modifier_of(event))

    def _apply_modifier_key(self, event: QKeyEvent, modifiers: Qt.KeyboardModifier) -> None:
        event.ignore()
        if event.key() in _MODIFIERS_BY_KEY and self._pointer is not None and not self.is_led_by_keys:
            self.dispatcher.set_modifiers(modifiers)
            self.dispatcher.move_pointer(self, self._pointer)

    def focusOutEvent(self, event: QFocusEvent) -> None:
        """Cancel the drag when the window loses the focus."""
        if self.dispatcher.is_dragging and event.reason() == Qt.FocusReason.ActiveWindowFocusReason:
            self.dispatcher.cancel_gesture()
        super().focusOutEvent(event)
