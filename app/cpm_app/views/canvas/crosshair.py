"""The cross-hair: keys move it in place of the pointer, so that every tool can be used without a mouse."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QCursor

from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.views.canvas.canvas import Canvas
from cpm_app.views.items.item import Markers
from cpm_app.views.theme import theme
from cpm_core.numerics import Position
from cpm_core.numerics.types import Callback

_CROSSHAIR_Z = 9.0
"""Place in the stack, above everything drawn on the image."""

_CROSSHAIR_SIZE = 36.0
"""Length from end to end [px of the screen]."""

_KEY_HIT_TOLERANCE = 0.9
"""Tolerance for hits of tools that work by clicks [px of the image]; keys are more precise than a mouse."""

_PAN_MARGIN = 24.0
"""Distance from the border of the canvas within which the cross-hair pans the image [px of the screen]."""


class Crosshair:
    """Presses, drags and releases on the canvas like the left button; `changed` is called when `advice` may change."""

    def __init__(self, canvas: Canvas, changed: Callback) -> None:
        self._canvas = canvas
        self._on_advice_changed = changed
        self.position: Position | None = None
        """Its position (row, col); None while it is hidden."""
        self._marks = [
            Markers(
                _CROSSHAIR_Z, size=_CROSSHAIR_SIZE, symbol="crosshair", brush=None, pen=pg.mkPen(color, width=width)
            )
            for color, width in ((theme.CANVAS_HALO_COLOR, 4.0), (theme.SELECTED_COLOR, 1.6))
        ]
        for marks in self._marks:
            canvas.view.addItem(marks, ignoreBounds=True)
        canvas.keyboard_interrupted.connect(self.hide_crosshair)

    @property
    def advice(self) -> str:
        """Sentence on the keys of the tool in use."""
        if self.position is None:
            return ""
        text = tr("Arrow keys move the cross-hair, with Shift by 10 px. {what} {key:escape} hides it.")
        return insert_keys(text, what=self._canvas.dispatcher.tool.keyboard_tip)

    def toggle_visibility(self) -> None:
        """Show or hide the cross-hair."""
        if self.position is None:
            self.show_crosshair()
        else:
            self.hide_crosshair()

    def show_crosshair(self) -> None:
        """Show the cross-hair under the pointer, or in the center of the canvas."""
        canvas = self._canvas
        shape = canvas.shape
        if shape is None:
            return
        inside = canvas.mapFromGlobal(QCursor.pos())
        under = canvas.underMouse() and canvas.rect().contains(inside)
        at = canvas.map_to_image((inside if under else canvas.rect().center()).toPointF())
        row, col = (min(max(round(place), 0), n - 1) for place, n in zip(at, shape, strict=True))
        self._move_to((float(row), float(col)))
        canvas.setFocus()

    def hide_crosshair(self) -> None:
        """Hide the cross-hair."""
        if self.position is not None:
            if self._canvas.dispatcher.is_dragging:
                self._canvas.dispatcher.cancel_gesture()
            self.position = None
            self._canvas.is_led_by_keys = False
            self._canvas.remove_pointer()
            self._draw_marks()
            self._on_advice_changed()

    def move_by(self, down: float, right: float) -> None:
        """Move the cross-hair, and whatever it drags, by px of the image."""
        if self.position is not None:
            self._move_to((self.position[0] + down, self.position[1] + right))

    def press_enter(self) -> None:
        """Press, release, or click, depending on the tool."""
        canvas, at, hold = self._canvas, self.position, self._canvas.dispatcher
        if at is None:
            return
        if hold.is_dragging:
            hold.release_button()
        elif hold.tool.works_by_clicks and hold.find_receiver(canvas, at) is hold.tool:
            hold.press_button(canvas, at, _KEY_HIT_TOLERANCE)
            hold.release_button()
        else:
            hold.press_button(canvas, at)
        self._on_advice_changed()

    def _move_to(self, at: Position) -> None:
        canvas = self._canvas
        canvas.is_led_by_keys, self.position = True, at
        point, seen = canvas.map_from_image(at), canvas.rect()
        room = QRectF(seen).adjusted(_PAN_MARGIN, _PAN_MARGIN, -_PAN_MARGIN, -_PAN_MARGIN)
        canvas.pan_by(
            point.x() - min(max(point.x(), room.left()), room.right()),
            point.y() - min(max(point.y(), room.top()), room.bottom()),
        )
        canvas.dispatcher.set_modifiers(Qt.KeyboardModifier.NoModifier)
        canvas.move_pointer_to(at)
        self._draw_marks()
        self._on_advice_changed()

    def _draw_marks(self) -> None:
        for marks in self._marks:
            marks.show_markers([] if self.position is None else [self.position])
