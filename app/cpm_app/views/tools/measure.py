"""The tools that measure: ruler, angle, and ellipse."""

from __future__ import annotations

from cpm_app.model.text.language import tr
from cpm_app.views.theme import theme
from cpm_app.views.tools.gesture_tools import DraggedTool
from cpm_app.views.tools.path import PathTool
from cpm_app.views.tools.tool import draw_shape
from cpm_core.numerics import Place
from cpm_core.shapes import SMALLEST_RADIUS, Angle, Oval, Ruler


class RulerTool(DraggedTool):
    """Draws a ruler from end to end."""

    name = "ruler"
    menu_text = tr("R&uler")
    panel = "measures"
    shortcut = "V"
    tip = tr("Drag from one point to another to measure their distance.")
    keyboard_tip = tr("Enter begins at one end, arrow keys move the other, Enter ends.")

    def on_drag(self, at: Place) -> None:
        """Extend the ruler to the pointer, unless that is back where it began."""
        if at != self.stroke[0]:
            super().on_drag(at)

    def build_shape(self, begin: Place, at: Place) -> Ruler:
        """Build the ruler between two places."""
        return Ruler((begin, at))


class AngleTool(PathTool):
    """Draws an angle: a drag, or two clicks, along the first side, and a click at the end of the other."""

    name = "angle"
    menu_text = tr("A&ngle")
    panel = "measures"
    shortcut = "Shift+V"
    tip = tr("Click three points to measure the angle at the second, or drag its first side.")
    keyboard_tip = tr("Enter places a point.")
    color = theme.MEASURE_COLOR
    closed = False

    @property
    def advice(self) -> str:
        """Sentence on what to do next."""
        return tr("Click the end of the other side.") if len(self._corners) == 2 else self.usage

    def on_press(self, at: Place) -> None:
        """Place a point; the third one finishes the angle."""
        if at not in self._corners:
            super().on_press(at)
        self.finish()

    def on_drag(self, at: Place) -> None:
        """Let the first side end at the pointer."""
        if self.is_dragged and self._is_first and at != self._corners[0]:
            self._corners[1:] = [at]

    def on_release(self) -> None:
        """Wait for the next point."""

    def finish(self) -> None:
        """Turn three points into an angle."""
        if len(self._corners) == 3:
            shape = Angle(tuple(self._corners))
            self.cancel()
            draw_shape(self._session, shape)


class OvalTool(DraggedTool):
    """Draws a measuring ellipse from corner to corner of its box; with Shift as a circle."""

    name = "oval"
    menu_text = tr("&Measuring ellipse")
    panel = "measures"
    short = tr("Mean")
    shortcut = "Z"
    tip = tr("Drag a box around an ellipse to measure the mean and the standard deviation in it; Shift makes it round.")
    keyboard_tip = tr("Enter begins at a corner of its box, arrow keys move the opposite one, Enter ends.")

    def build_shape(self, begin: Place, at: Place) -> Oval:
        """Build the ellipse in the dragged box."""
        (top, left), down, right = self.drag_in_slice(begin, at)
        center = self.place_in_image((top + 0.5 * down, left + 0.5 * right))
        radii = (max(0.5 * abs(down), SMALLEST_RADIUS), max(0.5 * abs(right), SMALLEST_RADIUS))
        here = self.current_slice
        if here is None:
            return Oval(center, radii)
        return Oval(center, radii[::-1] if here.transposed else radii, here.axis)
