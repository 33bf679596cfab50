"""Slices across the other axes of a volume beside the canvas, with a cross where the slices meet."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QMouseEvent, QWheelEvent
from PySide6.QtWidgets import QWidget

from app.model.text.language import tr
from app.model.volume.slices import AXES, Slices
from app.session.features.volumes.sections import Sections
from app.session.scene import Scene
from app.views.canvas.canvas import Wheel
from app.views.canvas.image_view import ImageView
from app.views.canvas.items.item import line_pen
from app.views.canvas.mirrors.mirror import Mirror
from app.views.theme import theme

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


class SideView(Mirror):
    """Shows the slice across one axis, as a whole; a click or a drag moves the cross, the wheel goes through slices."""

    went = Signal(object)
    """The user wants the slices through a place of the volume."""
    passed = Signal(int, int)
    """The user wants the slice so many further along an axis: axis, number."""

    def __init__(self, canvas: ImageView, parent: QWidget) -> None:
        super().__init__(canvas, parent)
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents, False)
        self.setMinimumSize(_SMALLEST, _SMALLEST)
        self.viewport().setCursor(Qt.CursorShape.CrossCursor)
        self.cross = Cross(self)
        self._fitted = True
        self._wheel = Wheel()

    def show_slice(self, scene: Scene, axis: int) -> None:
        """Draw the slice of a scene across an axis."""
        if self.sections.axis != axis:
            self.sections = Sections(axis)
            self.setAccessibleName(tr("Slice across the axis: {axis}").format(axis=AXES[axis]))
            self.setToolTip(tr("Click to move the cross and with it the other slices; the wheel goes through these."))
        self.draw(scene)
        self.cross.show(self.drawn.slices)

    def fit(self) -> None:
        """Show the whole slice: it has a place of its own."""
        ImageView.fit(self)

    def mousePressEvent(self, event: QMouseEvent) -> None:
        """Move the cross."""
        event.accept()
        if event.button() == Qt.MouseButton.LeftButton:
            self.went.emit(self.placed(self.position(event.position())))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:
        """Move the cross as long as the button is down."""
        event.accept()
        if event.buttons() & Qt.MouseButton.LeftButton:
            self.went.emit(self.placed(self.position(event.position())))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:
        """Leave the cross where it is."""
        event.accept()

    def wheelEvent(self, event: QWheelEvent) -> None:
        """Go through the slices of this view."""
        event.accept()
        if self.sections.axis is not None:
            self.passed.emit(self.sections.axis, self._wheel.notches(event))
