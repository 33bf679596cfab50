"""The tool that mends objects: pulls their outlines, and paints them."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import Qt
from PySide6.QtGui import QCursor

from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.session.features.outline_editing import HeldCurve
from cpm_app.views.theme import theme
from cpm_app.views.tools.brush_tools import RingTool
from cpm_app.views.tools.tool import REMOVE_MODIFIER, Cursor
from cpm_core.numerics import Place, Position
from cpm_core.numerics.types import NO_POINTS, Line
from cpm_core.objects.segmented import SegmentedObject
from cpm_core.reconstruction import RedrawnCurve, pull_curve

_REDRAW_ADVICE = tr("Release to redraw the line along the edge; Shift only bends it. {key:escape} cancels.")
"""Advice while an outline is dragged."""

_CONTOUR_ADVICE = tr("Drag to pull the contour: it becomes an object, as if you had accepted it.")
"""Advice over a contour of the run."""

_ERASE_ADVICE = tr("Drag to erase from {name}. [ and ] change the brush.")
"""Advice with Shift over an object."""

_ERASE_ANYWHERE_ADVICE = tr("Drag over an object to erase from it. [ and ] change the brush.")
"""Advice with Shift away from objects."""

_ADD_ADVICE = tr(
    "Drag to add to {name}, Shift-drag to erase, Ctrl-drag to paint a new object. [ and ] change the brush."
)
"""Advice over an object."""

_PAINT_ADVICE = tr("Drag to paint a new object. [ and ] change the brush.")
"""Advice away from objects."""


class MendTool(RingTool):
    """Near an outline it pulls it, away from outlines it is a brush that adds to objects, with Shift takes away.

    A contour of the run becomes an object when it is pulled. What a press would do is shown before it, what a release
    would do as a preview. In a volume it is the brush alone.
    """

    name = "mend"
    menu_text = tr("&Mend")
    shortcut = "J"
    panel = "objects"
    tip = tr("Drag an outline to pull it, elsewhere to paint; Shift bends it or erases.")
    keyboard_tip = tr("Enter picks up or paints, with Shift erases; arrow keys move, Enter ends.")
    drag_distance = 0.5

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        super().set_up()
        self._editing, self._contours = self._workspace.outline_editing, self._workspace.contour_selection
        self._list = self._workspace.object_list
        self._brush = self._workspace.object_brush
        self._objects = self._session.document.objects
        self._held: HeldCurve | None = None
        """The place of an outline that is under the pointer, or in hand."""
        self._painted: SegmentedObject | None = None
        """The object that the brush would paint; None for a new one."""
        self._obstacle = ""
        """Why the brush would do nothing here, as a sentence."""
        self._brush.changed.connect(self.update_marks)

    @property
    def radius(self) -> float:
        """Radius of the brush [px of the image]."""
        return self._brush.radius

    def set_radius(self, radius: float) -> None:
        """Set the radius of the brush [px of the image]."""
        self._brush.set_radius(radius)

    @property
    def advice(self) -> str:
        """Sentence on what a press or a release does here."""
        held, away = self._held, self._is_removing
        if held is not None and self.is_dragged:
            return insert_keys(_REDRAW_ADVICE)
        item = self._painted if held is None else held.item
        name = "" if item is None else self._list.title_of(item)
        if held is not None and item is not None:
            words = tr("Drag to bend the boundary of {name}.") if away else tr("Drag to pull the boundary of {name}.")
        elif held is not None:
            words = _CONTOUR_ADVICE
        elif self.pointer is None:
            words = self.usage
        elif self._obstacle:
            return self._obstacle
        elif away:
            words = _ERASE_ADVICE if item is not None else _ERASE_ANYWHERE_ADVICE
        else:
            words = _ADD_ADVICE if item is not None else _PAINT_ADVICE
        return insert_keys(words, name=name)

    def on_press(self, at: Position) -> None:
        """Grab the outline under the pointer, or begin to paint."""
        self._find_target(at)
        if self._held is None:
            super().on_press(at)

    def on_drag(self, at: Position) -> None:
        """Continue to paint, unless an outline is pulled."""
        if self._held is None:
            super().on_drag(at)

    def on_release(self) -> None:
        """Carry out what the preview shows, select what was clicked, or end the stroke."""
        held = self._held
        if held is not None and self.is_dragged:
            self._editing.redraw_curve(held, self._pull_curve(held), not self._is_removing)
        elif held is not None:
            self._list.select_items((("contour", held.index) if held.item is None else ("object", held.item.number),))
        self._finish_gesture()

    def on_hover(self, at: Position) -> None:
        """Preview what a press here would grab or paint."""
        self._find_target(at)

    def apply_along(self, path: Line) -> None:
        """Begin a stroke, or continue it."""
        if len(path) == 1:
            self._objects = self._session.document.objects
            axis = None if self.current_slice is None or self._brush.paints_in_space else self.current_slice.axis
            self._brush.begin_stroke(path[0], not self._is_removing, self._gesture, axis, self._paints_new_object)
        else:
            self._brush.extend_stroke(path[-1])

    def cancel(self) -> None:
        """Give up the drag, or restore the objects from before the stroke."""
        before = self._objects
        if self._brush.painting:
            self._session.edit("", lambda document: replace(document, objects=before), self._gesture)
        self._finish_gesture()
        super().cancel()

    def hide_marks(self) -> None:
        """Hide the preview and the ring."""
        self._held = None
        super().hide_marks()

    def cursor_at(self, at: Position) -> Cursor | QCursor:
        """Return a hand over an outline, elsewhere a cross, or a bar where the brush would do nothing."""
        if self.volume is None:
            self._editing.request_edges()
        if self._held is not None:
            return Cursor.OpenHandCursor
        return Cursor.ForbiddenCursor if self._obstacle else Cursor.CrossCursor

    @property
    def _is_removing(self) -> bool:
        return bool(self.modifiers & REMOVE_MODIFIER)

    @property
    def _paints_new_object(self) -> bool:
        """Whether a new object is painted."""
        return bool(self.modifiers & Qt.KeyboardModifier.ControlModifier) and not self._is_removing

    def _find_target(self, at: Place) -> None:
        """Find the outline or object that a press at a place would act on."""
        self._held = None if self.volume is not None else self._editing.find_curve(at, self.reach)
        self._painted, self._obstacle = None, ""
        if self._held is None:
            adds, makes_new = not self._is_removing, self._paints_new_object
            self._painted = None if makes_new else self._brush.find_target((at,), self.radius, adds)
            self._obstacle = self._brush.find_obstacle(at, self._painted, adds, makes_new)

    def _pull_curve(self, held: HeldCurve) -> RedrawnCurve:
        """Return the curve that a release at the pointer makes of the held one."""
        assert self.pointer is not None
        return pull_curve(held.place, self.pointer, None if self._is_removing else self._editing.edges)

    def draw_marks(self) -> None:
        """Draw the preview, or the place under the pointer and the ring."""
        held, path = self._held, NO_POINTS
        if held is not None and self.is_dragged and self.pointer is not None:
            path = self._pull_curve(held).drawn
        self._contours.set_hovered(held.index if held is not None and held.item is None else None)
        adds = self._brush.adds if self._brush.painting else not self._is_removing
        self._drawing.show_draft([] if held is None else [held.place.place], path, theme.BY_HAND_COLOR)
        self._drawing.show_ring(
            self.pointer if held is None else None,
            self.radius,
            theme.RESTING_COLOR if adds else theme.BARRIER_COLOR,
            None if self.current_slice is None or self._brush.paints_in_space else self.current_slice.axis,
        )

    def _finish_gesture(self) -> None:
        self._brush.end_stroke()
        self._held = None
        self._end_gesture()
        if self.pointer is not None:
            self._find_target(self.pointer)
