"""Slices across the other axes of a volume next to the canvas, with a cross where the slices meet."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt, Signal
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import AXES, Slices
from cpm_app.session.features.slices import Sections
from cpm_app.session.scene import Scene
from cpm_app.views.canvas.canvas import ZOOM, Canvas, Pointer, Wheel
from cpm_app.views.canvas.image_view import ImageView
from cpm_app.views.items.item import image_rectangle, line_pen
from cpm_app.views.theme import theme
from cpm_core.numerics import Position

_Z = 8.5
_SMALLEST = 120
"""Least width and height [px of the screen]."""


class Cross:
    """Two lines in a view of a slice: where the two other slices cut it."""

    def __init__(self, view: ImageView) -> None:
        self._lines = [pg.InfiniteLine(angle=angle, pen=line_pen(theme.CHOSEN, 1.0)) for angle in (0, 90)]
        for line in self._lines:
            line.setZValue(_Z)
            line.setOpacity(0.6)
            line.hide()
            view.view.addItem(line, ignoreBounds=True)

    def show(self, slices: Slices | None) -> None:
        """Show where the slices meet; without slices nothing."""
        for line in self._lines:
            line.setVisible(slices is not None)
        if slices is not None:
            for line, at in zip(self._lines, slices.current.within(slices.voxel), strict=True):
                line.setValue(at)


class SideView(ImageView):
    """Shows the slice across one axis, at first as a whole, and takes the tool in use.

    The right button moves the cross, and a click of it on something opens its menu; the wheel goes through the slices,
    with Ctrl it zooms, and the middle button pans.
    """

    went = Signal(object)
    """The user wants the slices through a place of the volume."""
    passed = Signal(int, int)
    """The user wants the slice so many further along an axis: axis, number."""

    def __init__(self, canvas: Canvas, parent: QWidget) -> None:
        super().__init__(original=canvas)
        self.setParent(parent)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setMinimumSize(_SMALLEST, _SMALLEST)
        self.cross = Cross(self)
        self._main = canvas
        self._wheel = Wheel()
        self.pointer = Pointer(self, canvas)
        self.pointer.moved.connect(self._move)
        self.pointer.dragged.connect(self._drag)
        drawing = canvas.layers.drawing
        drawing.draft_shown.connect(self.layers.drawing.show_draft)
        drawing.ring_shown.connect(self.layers.drawing.show_ring)

    def show_slice(self, scene: Scene, axis: int) -> None:
        """Draw the slice of a scene across an axis."""
        if self.sections.axis != axis:
            self.sections = Sections(axis, self.sections.later)
            self.setAccessibleName(tr("Slice across the axis: {axis}", axis=AXES[axis]))
        self.draw(scene)
        self.cross.show(self.drawn.slices)

    def _move(self, at: Position) -> None:
        """Pass the pointer to the tool in use."""
        self._main.hold.move(self, at)
        self._main.placed_at.emit(self.placed(at))

    def _drag(self, event: QMouseEvent, by: QPointF) -> None:
        """Move the cross with the right button, the image with the middle one."""
        if event.buttons() & Qt.MouseButton.RightButton:
            place = self.placed(self.position(event.position()))
            self.went.emit(place)
            self._main.placed_at.emit(place)
        else:
            self.pan(by.x(), by.y())

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Go through the slices of this view; with Ctrl zoom around the pointer, at the least to the whole slice."""
        event.accept()
        if event.modifiers() & Qt.KeyboardModifier.ControlModifier:
            self.zoom(ZOOM ** (event.angleDelta().y() / 120.0), event.position())
            if self.shape is not None and self.view.viewRect().contains(image_rectangle(self.shape)):
                self.fit()
        elif self.sections.axis is not None:
            self.passed.emit(self.sections.axis, self._wheel.notches(event))
