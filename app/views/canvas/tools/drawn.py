"""The tools that draw a shape with one gesture: circle, ellipse and point."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt

from app.model.text.language import tr
from app.session.signals import EDITING
from app.views.canvas.tools.tool import ShapeTool, ToolContext
from cpm_core.numerics.types import Position
from cpm_core.shapes import SMALLEST_RADIUS, Circle, Ellipse, Points, Shape, Sphere
from cpm_core.shapes.sphere import SMALLEST

SLIP_IN_VOLUME = tr("Keep the button down and drag to draw a sphere from its center.")
"""Message when the pointer has not been moved in a volume."""


class DraggedTool(ShapeTool):
    """Draws a shape between the place where the button goes down and the pointer."""

    activity: str
    """Name of the edit, as shown after "Undo"."""
    slip: str
    """Message when the pointer has not been moved."""

    def __init__(self, context: ToolContext) -> None:
        super().__init__(context)
        self._start: Position = (0.0, 0.0)

    def shape(self, begin: Position, at: Position) -> Shape:
        """The shape between two places."""
        raise NotImplementedError

    def press(self, at: Position, reach: float) -> None:
        """Begin a shape."""
        self._start = at
        self._begin()

    def drag(self, at: Position) -> None:
        """Extend the shape to the pointer."""
        if self._index is not None and (self._drawn or math.dist(self._start, at) >= SMALLEST_RADIUS):
            shape = self.shape(self._start, at)
            self._put(tr("draw sphere") if isinstance(shape, Sphere) else self.activity, shape)
            self._session.select(self._index)

    def release(self) -> None:
        """Keep the shape."""
        if self._index is not None and self._drawn is None:
            in_volume = self._session.scene.slices is not None
            self._session.say(SLIP_IN_VOLUME if in_volume else self.slip, topic=EDITING)
        self.used = True
        super().release()


class CircleTool(DraggedTool):
    """Draws a circle from its center."""

    name = "circle"
    tip = tr("Drag from the center to draw a circle.")
    activity = tr("draw circle")
    slip = tr("Keep the button down and drag to draw a circle from its center.")
    by_keys = tr("Enter begins at the center, arrow keys move the rim, Enter ends.")

    def shape(self, begin: Position, at: Position) -> Circle | Sphere:
        """The circle around `begin` through the pointer, in a volume the sphere."""
        image = self._session.document.image
        if image is not None and len(image.shape) == 3:
            return Sphere.round(begin, SMALLEST, image.spacing).with_handle_at(begin, at)
        return Circle(begin, max(math.dist(begin, at), SMALLEST_RADIUS))


class EllipseTool(DraggedTool):
    """Draws an ellipse from corner to corner of its box; with Ctrl from its center, with Shift as a circle."""

    name = "ellipse"
    tip = tr("Drag a box to draw an ellipse; Shift makes it round, Ctrl draws it from its center.")
    activity = tr("draw ellipse")
    slip = tr("Keep the button down and drag to draw an ellipse.")
    guidance = tr("Drag a box around the ellipse; Shift makes it round, Ctrl draws it from its center.")
    by_keys = tr("Enter begins at a corner of its box, arrow keys move the opposite one, Enter ends.")
    _held = Qt.KeyboardModifier.NoModifier

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """Remember the modifier keys."""
        self._held = modifiers

    def shape(self, begin: Position, at: Position) -> Ellipse:
        """The ellipse in the box; its first radius lies along the row."""
        down, right = at[0] - begin[0], at[1] - begin[1]
        if self._held & Qt.KeyboardModifier.ShiftModifier:
            size = max(abs(down), abs(right))
            down, right = math.copysign(size, down), math.copysign(size, right)
        share, center = 1.0, begin
        if not self._held & Qt.KeyboardModifier.ControlModifier:
            share, center = 0.5, (begin[0] + 0.5 * down, begin[1] + 0.5 * right)
        return Ellipse(center, (max(share * abs(right), SMALLEST_RADIUS), max(share * abs(down), SMALLEST_RADIUS)))


class PointTool(ShapeTool):
    """Places a point, which follows the pointer while the button is down."""

    name = "points"
    tip = tr("Click to place a point.")
    clicks = True
    by_keys = tr("Enter places a point.")

    def press(self, at: Position, reach: float) -> None:
        """Place a point."""
        self._begin()
        self.drag(at)
        self._session.select(None)

    def drag(self, at: Position) -> None:
        """Move the point to the pointer."""
        self._put(tr("place point"), Points((at,)))
