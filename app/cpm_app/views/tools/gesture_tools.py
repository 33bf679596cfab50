"""The tools that draw a shape with one gesture: circle, ellipse, point, and charges."""

from __future__ import annotations

import math
import operator

import numpy as np
from PySide6.QtCore import Qt

from cpm_app.model.document.document import ImageReference
from cpm_app.model.text.language import tr
from cpm_app.model.volume.slices import Slice
from cpm_app.views.tools.tool import ShapeTool
from cpm_core.numerics import Place, Position
from cpm_core.shapes import SMALLEST_RADIUS, Box, Charge, Circle, Ellipse, Points, Shape, Sphere
from cpm_core.shapes.solids import MIN_BOX_SIDE


def box_between(one: Position, other: Position, here: Slice, volume: ImageReference) -> tuple[Place, Place]:
    """Return two corners of a box in the volume, centered on the slice and as deep as its shorter side."""
    axis, low, high = here.axis, *np.sort([one, other], axis=0)
    high = np.maximum(high, low + MIN_BOX_SIDE)
    depth = ((high - low) * here.drop_axis(volume.spacing)).min()
    half = max(0.5 * float(depth) / volume.spacing[axis], MIN_BOX_SIDE)
    begin = max(here.index - half, 0.0)
    # not flat, even in a volume of a single slice
    end = max(min(here.index + half, volume.shape[axis] - 1.0), begin + MIN_BOX_SIDE)
    first, last = ([*here.lift_position(tuple(corner.tolist()))] for corner in (low, high))
    first[axis], last[axis] = begin, end
    return tuple(first), tuple(last)


class DraggedTool(ShapeTool):
    """Draws a shape between the place of the press and the pointer."""

    def build_shape(self, begin: Position, at: Position) -> Shape:
        """Build the shape between two places."""
        raise NotImplementedError

    def drag_in_slice(self, begin: Position, at: Position) -> tuple[Position, float, float]:
        """Return where a drag began in its slice, and how far it goes down and right; equally far with Shift."""
        start = self.position_in_slice(begin)
        down, right = map(operator.sub, self.position_in_slice(at), start)
        if self.modifiers & Qt.KeyboardModifier.ShiftModifier:
            high, wide = self.pixel_sides
            size = max(abs(down) * high, abs(right) * wide)
            down, right = math.copysign(size / high, down), math.copysign(size / wide, right)
        return start, down, right

    def on_press(self, at: Position) -> None:
        """Begin a shape."""
        self._begin_gesture()

    def on_drag(self, at: Position) -> None:
        """Extend the shape to the pointer."""
        if self._drawn_shape or math.dist(self.stroke[0], at) >= SMALLEST_RADIUS:
            self._put_shape(tr("draw {shape}"), self.build_shape(self.stroke[0], at))
            self._session.select_shape(self._index)

    def on_release(self) -> None:
        """Keep the shape."""
        if self._drawn_shape is None:
            self.show_message(tr("Keep the button down. {advice}", advice=self.usage))
        super().on_release()


class CircleTool(DraggedTool):
    """Draws a circle from its center."""

    name = "circle"
    menu_text = tr("&Circle")
    shortcut = "C"
    tip = tr("Drag from the center to draw a circle.")
    keyboard_tip = tr("Enter begins at the center, arrow keys move the rim, Enter ends.")

    def build_shape(self, begin: Position, at: Position) -> Circle | Sphere:
        """Build the circle, or in a volume the sphere, around `begin` through the pointer."""
        if self.volume is not None:
            return Sphere.from_voxel_size(begin, MIN_BOX_SIDE, self.volume.spacing).with_handle_at(begin, at)
        return Circle(begin, max(math.dist(begin, at), SMALLEST_RADIUS))


class EllipseTool(DraggedTool):
    """Draws an ellipse from corner to corner of its box; with Ctrl from its center, with Shift as a circle.

    In a volume it draws the box itself, as deep as its shorter side.
    """

    name = "ellipse"
    menu_text = tr("E&llipse")
    shortcut = "L"
    tip = tr("Drag a box to draw an ellipse; Shift makes it round, Ctrl draws it from its center.")
    guidance = tr("Drag a box around the ellipse; Shift makes it round, Ctrl draws it from its center.")
    keyboard_tip = tr("Enter begins at a corner of its box, arrow keys move the opposite one, Enter ends.")

    def build_shape(self, begin: Position, at: Position) -> Ellipse | Box:
        """Build the ellipse in the dragged box, its first radius along the row; in a volume, the box."""
        (top, left), down, right = self.drag_in_slice(begin, at)
        centered = bool(self.modifiers & Qt.KeyboardModifier.ControlModifier)
        if self.volume is not None and self.current_slice is not None:
            one = (top - down, left - right) if centered else (top, left)
            return Box(*box_between(one, (top + down, left + right), self.current_slice, self.volume))
        share, center = 1.0, begin
        if not centered:
            share, center = 0.5, (top + 0.5 * down, left + 0.5 * right)
        return Ellipse(center, (max(share * abs(right), SMALLEST_RADIUS), max(share * abs(down), SMALLEST_RADIUS)))


class PointTool(ShapeTool):
    """Places a point, which follows the pointer while the button is down."""

    name = "points"
    menu_text = tr("&Points")
    shortcut = "P"
    tip = guidance = tr("Click to place a point.")
    works_by_clicks = True
    keyboard_tip = tr("Enter places a point.")

    def on_press(self, at: Position) -> None:
        """Place a point."""
        self._begin_gesture()
        self.on_drag(at)
        self._session.select_shape(None)

    def on_drag(self, at: Position) -> None:
        """Move the point to the pointer, as long as that is in the image."""
        if self.is_in_image(at):
            self._put_shape(tr("place point"), Points((at,)))


class ChargeTool(ShapeTool):
    """Places a charge or grabs an existing one; it follows the pointer while the button is down."""

    keyboard_tip = tr("Enter places it or picks one up, arrow keys move it, Enter puts it down.")
    strength: float
    """Strength of new charges; positive ones attract."""

    def on_press(self, at: Place) -> None:
        """Grab the charge under the pointer, or place one."""
        self._begin_gesture(self._find_charge(at))
        if self._before is None:
            self._put_charge(Charge(at, self.strength))
        self._session.select_shape(self._index)

    def on_drag(self, at: Place) -> None:
        """Move the charge to the pointer."""
        charge = self._drawn_shape
        if isinstance(charge, Charge):
            self._put_charge(Charge(at, charge.strength))

    def _put_charge(self, charge: Charge) -> None:
        self._put_shape(tr("drop {shape}") if self._before is None else tr("move {shape}"), charge)

    def _find_charge(self, at: Place) -> int | None:
        """Find the index of the charge nearest to the pointer, of equally near ones the topmost."""
        near = [
            (math.dist(shape.position, at), -index)
            for index, shape in enumerate(self._session.document.shapes)
            if isinstance(shape, Charge) and math.dist(shape.position, at) <= self.reach
        ]
        return -min(near)[1] if near else None


class AttractTool(ChargeTool):
    """Places charges that attract particles."""

    name = "attract"
    menu_text = tr("&Attract")
    shortcut = "A"
    tip = tr("Place a charge that attracts particles, and drag it while they run; [ and ] change its strength.")
    guidance = tr("Click to place a charge that attracts particles; drag it while they run.")
    strength = 2.0


class RepelTool(ChargeTool):
    """Places charges that repel particles."""

    name = "repel"
    menu_text = tr("&Repel")
    shortcut = "D"
    tip = tr("Place a charge that repels particles, and drag it while they run; [ and ] change its strength.")
    guidance = tr("Click to place a charge that repels particles; drag it while they run.")
    strength = -2.0
