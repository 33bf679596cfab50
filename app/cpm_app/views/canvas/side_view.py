"""Slices across the other axes of a volume, next to the canvas, with a cross where the slices meet."""

from __future__ import annotations

import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt
from PySide6.QtWidgets import QWidget

from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import AXIS_NAMES, Slices
from cpm_app.session.features.slices import Sections
from cpm_app.session.scene import Scene
from cpm_app.views.canvas.canvas import Canvas, ToolView
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
    """Shows the slice across one axis, and works with the tool in use; a right click on an item opens the menu."""

    def __init__(self, canvas: Canvas, parent: QWidget) -> None:
        super().__init__(original=canvas)
        self.setParent(parent)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setMinimumSize(_MIN_SIDE_VIEW_SIZE, _MIN_SIDE_VIEW_SIZE)
        self.cross = SliceCross(self)
        self.canvas = canvas
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

    def zoom_by(self, factor: float, around: QPointF | None = None) -> None:
        """Enlarge around a point of the widget; make smaller until the whole slice is visible."""
        super().zoom_by(factor, around)
        if self.shape is not None and self.view.viewRect().contains(image_rectangle(self.shape)):
            self.fit_image()
