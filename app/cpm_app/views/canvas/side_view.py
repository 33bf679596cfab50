"""Slices across the other axes of a volume, next to the canvas, with a cross where the slices meet."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import AXIS_NAMES, Slices
from cpm_app.session.features.slices import Sections
from cpm_app.session.scene import Scene
from cpm_app.views.canvas.canvas import WHEEL_ZOOM_FACTOR, Canvas, ToolView, WheelNotchCounter
from cpm_app.views.canvas.image_view import ImageView
from cpm_app.views.items.item import image_rectangle, line_pen
from cpm_app.views.theme import theme
from cpm_core.numerics import Position

_SLICE_CROSS_Z = 8.5
"""Place of the cross in the stack, above the layers."""

_MIN_SIDE_VIEW_SIZE = 120
"""Minimum width and height [px of the screen]."""


class SliceCross:
    """Two lines where the two other slices cut a view."""

    def __init__(self, view: ImageView) -> None:
        self._lines = [pg.InfiniteLine(angle=angle, pen=line_pen(theme.SELECTED_COLOR, 1.0)) for angle in (0, 90)]
        for line in self._lines:
            line.setZValue(_SLICE_CROSS_Z)
            line.setOpacity(0.6)
            line.hide()
            view.view.addItem(line, ignoreBounds=True)

    def show_slices(self, slices: Slices | None) -> None:
        """Show where the slices meet; without slices, show nothing."""
        for line in self._lines:
            line.setVisible(slices is not None)
        if slices is not None:
            for line, at in zip(self._lines, slices.current.drop_axis(slices.voxel), strict=True):
                line.setValue(at)


class SideView(ToolView):
    """Shows the slice across one axis, and works with the tool in use.

    The right button moves the cross, and its click on an item opens the menu; the wheel steps through the slices, with
    Ctrl it zooms, and the middle button pans.
    """

    place_wanted = Signal(object)
    """Place of the volume that the user wants the slices through."""
    slice_step_wanted = Signal(int, int)
    """Axis, and the number of slices by which the user wants to move along it."""

    def __init__(self, canvas: Canvas, parent: QWidget) -> None:
        super().__init__(original=canvas)
        self.setParent(parent)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setMinimumSize(_MIN_SIDE_VIEW_SIZE, _MIN_SIDE_VIEW_SIZE)
        self.cross = SliceCross(self)
        self.canvas = canvas
        self._wheel = WheelNotchCounter()
        drawing = canvas.layers.drawing
        drawing.draft_shown.connect(self.layers.drawing.show_draft)
        drawing.ring_shown.connect(self.layers.drawing.show_ring)

    def show_slice(self, scene: Scene, axis: int) -> None:
        """Draw the slice of a scene across an axis."""
        if self.sections.axis != axis:
            self.sections = Sections(axis, self.sections.later)
            self.setAccessibleName(tr("Slice across the axis: {axis}", axis=AXIS_NAMES[axis]))
        self.draw_scene(scene)
        self.cross.show_slices(self.drawn_scene.slices)

    def move_pointer_to(self, at: Position) -> None:
        """Move the pointer of the tool in use."""
        self.canvas.dispatcher.move_pointer(self, at)
        self.canvas.pointer_place_changed.emit(self.place_at(at))

    def drag_by(self, event: QMouseEvent, by: QPointF) -> None:
        """Move the cross with the right button, the image with the middle one."""
        if event.buttons() & Qt.MouseButton.RightButton:
            place = self.place_at(self.map_to_image(event.position()))
            self.place_wanted.emit(place)
            self.canvas.pointer_place_changed.emit(place)
        else:
            self.pan_by(by.x(), by.y())

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Step through the slices of this view; with Ctrl, zoom around the pointer, out to the whole slice at most."""
        event.accept()
        if event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            self.zoom_by(WHEEL_ZOOM_FACTOR ** (event.angleDelta().y() / 120.0), event.position())
            if self.shape is not None and self.view.viewRect().contains(image_rectangle(self.shape)):
                self.fit_image()
        elif self.sections.axis is not None:
            self.slice_step_wanted.emit(self.sections.axis, self._wheel.count_notches(event))
