"""The tool that mends contours and objects: pulls and joins lines, cuts contours, and paints objects."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QCursor

from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.session.session_messages import EDITING_CATEGORY
from cpm_app.views.theme import theme
from cpm_app.views.theme.icons import create_pointer
from cpm_app.views.tools.brush_tools import RingTool
from cpm_app.views.tools.tool import MEND_GROUP, REMOVE_MODIFIER, Cursor
from cpm_core.contours import HandEdit
from cpm_core.numerics import Array, Place, Position
from cpm_core.numerics.types import Line
from cpm_core.objects.segmented import SegmentedObject
from cpm_core.reconstruction import Contact, connect_by_path, delete_stretch, pull_contour

_CLICK_TOLERANCE = 0.5
"""Largest move of the pointer during a click; beyond it, a press is a drag [hit tolerances]."""

_JOIN_ADVICE = tr("Release on another end to join, elsewhere to extend. {key:escape} cancels.")
"""Advice while an end of a contour is dragged."""

_REDRAW_ADVICE = tr("Release to redraw the line along the edge; Shift only bends it. {key:escape} cancels.")
"""Advice while a line is dragged."""

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
    """Near a line it pulls it, from an end of a contour it joins; a click marks a place there, with Shift it cuts.

    Away from lines it is a brush that adds to objects, with Shift takes away. What a press would do is shown before it,
    what a release would do as a preview. In a volume it is the brush alone.
    """

    name = "mend"
    menu_text = tr("&Mend")
    shortcut = "J"
    group = MEND_GROUP
    panel = "objects"
    tip = tr("Drag a line to pull it, an end of a contour to join it, elsewhere to paint; Shift cuts or erases.")
    keyboard_tip = tr("Enter picks up or paints, with Shift cuts or erases; arrow keys move, Enter ends.")

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        super().set_up()
        self._editing, self._review = self._workspace.hand_editing, self._workspace.review
        self._list = self._workspace.object_list
        self._brush = self._workspace.object_brush
        self._objects = self._session.document.objects
        self._held: Contact | None = None
        """The place of a line that is under the pointer, or in hand."""
        self._item: SegmentedObject | None = None
        """The object whose boundary that is, or that the brush would paint; None for a contour or a new object."""
        self._obstacle = ""
        """Why the brush would do nothing here, as a sentence."""
        self._pressed: Position | None = None
        self._dragged = False
        self._way = self._editing.path_from((0.0, 0.0))
        self._reach = 1.0
        self._editing.changed.connect(self._show_preview)
        self._brush.changed.connect(self._show_preview)

    @property
    def radius(self) -> float:
        """Radius of the brush [px of the image]."""
        return self._brush.radius

    def set_radius(self, radius: float) -> None:
        """Set the radius of the brush [px of the image]."""
        self._brush.set_radius(radius)

    @property
    def has_draft(self) -> bool:
        """Whether places are marked."""
        return bool(self._editing.marked_places)

    @property
    def advice(self) -> str:
        """Sentence on what a press or a release does here."""
        held, item, away = self._held, self._item, self._is_removing
        name = "" if item is None else self._list.title_of(item)
        if held is not None and self._dragged:
            return insert_keys(_JOIN_ADVICE if held.at_end else _REDRAW_ADVICE)
        if held is not None and item is not None:
            words = tr("Drag to bend the boundary of {name}.") if away else tr("Drag to pull the boundary of {name}.")
        elif held is not None:
            words = self._contour_advice(held)
        elif self._pointer is None:
            words = self.tip
        elif self._obstacle:
            return self._obstacle
        elif away:
            words = _ERASE_ADVICE if item is not None else _ERASE_ANYWHERE_ADVICE
        else:
            words = _ADD_ADVICE if item is not None else _PAINT_ADVICE
        return insert_keys(words, name=name)

    def _contour_advice(self, held: Contact) -> str:
        """Return the advice for a place of a contour."""
        if held.at_end:
            return tr("Drag to another end to join them, elsewhere to extend this contour.")
        if self._is_removing:
            return tr("Click to cut the contour here, drag to bend it.")
        if len(self._editing.marked_places) == 2:
            return tr("Delete removes the segment between the marks; {key:escape} removes the marks.")
        if self._editing.marked_places:
            return tr("Click a second point to mark a segment.")
        return tr("Drag to pull the contour, click to mark a place, Shift-click to cut.")

    def on_press(self, at: Position, reach: float) -> None:
        """Grab the line under the pointer, or begin to paint."""
        self._find_target(at, reach)
        self.used, self._pressed, self._dragged = True, at, False
        if self._held is None:
            self._editing.mark_places(())
            super().on_press(at, reach)
        elif self._held.at_end:
            self._way = self._editing.path_from_end(self._held)

    def on_drag(self, at: Position) -> None:
        """Preview a release here, or continue to paint."""
        if self._held is None:
            super().on_drag(at)
        elif self._pressed is not None:
            self._pointer = at
            self._dragged = self._dragged or math.dist(self._pressed, at) > _CLICK_TOLERANCE * self._reach
            self._show_preview()

    def on_release(self) -> None:
        """Carry out what the preview shows, mark the place that was clicked, or end the stroke."""
        held, item = self._held, self._item
        if held is not None and self._dragged:
            edits = self._compute_edit(held)[0]
            if item is None:
                self._editing.add_edits(edits)
            elif item.frozen:
                frozen = tr("{name} is frozen: unfreeze it to change it.").format(name=self._list.title_of(item))
                self._session.messages.show(frozen, category=EDITING_CATEGORY)
            else:
                self._editing.redraw_boundary(item, held, edits[0], not self._is_removing)
        elif held is not None:
            self._on_click(held, item)
        self._finish_gesture()

    def on_hover(self, at: Position) -> None:
        """Preview what a press here would grab or paint."""
        self._pointer = at
        if self._pressed is None:
            self._find_target(at, self._reach)
        self._show_preview()

    def apply_along(self, path: Line) -> None:
        """Begin a stroke, or continue it."""
        if len(path) == 1:
            self._objects = self._session.document.objects
            axis = None if self.current_slice is None or self._brush.paints_in_space else self.current_slice.axis
            self._brush.begin_stroke(path[0], not self._is_removing, self._gesture, axis, self._paints_new_object)
        else:
            self._brush.extend_stroke(path[-1])

    def finish(self) -> None:
        """Keep the marks, because keys and menus act on them."""

    def remove_last_part(self) -> None:
        """Delete the marked stretch, or remove a single mark."""
        if len(self._editing.marked_places) == 2:
            self._editing.delete_stretch()
        else:
            self._editing.mark_places(())

    def cancel(self) -> None:
        """Give up the drag, restore the objects from before the stroke, or remove the marks."""
        before = self._objects
        if self._brush.painting:
            self._session.edit("", lambda document: replace(document, objects=before), self._gesture)
        if self._pressed is None:
            self._editing.mark_places(())
        self._finish_gesture()

    def hide_marks(self) -> None:
        """Hide the preview, the marks and the ring."""
        self._pointer = self._held = None
        self._review.set_hovered(None)
        self._drawing.show_draft()
        self._drawing.show_ring()

    def cursor_at(self, at: Position, reach: float) -> Cursor | QCursor:
        """Return links over an end, a knife or a hand over a line, elsewhere a cross, or a bar if it paints nothing."""
        if self.volume is None:
            self._editing.request_edges()
        if self._reach != max(reach, 1.0) and self._pointer is not None:
            self._find_target(at, reach)
            self._show_preview()
        if self._held is None:
            return Cursor.ForbiddenCursor if self._obstacle else Cursor.CrossCursor
        if self._held.at_end:
            return create_pointer("join")
        return create_pointer("knife") if self._is_removing and self._item is None else Cursor.OpenHandCursor

    @property
    def _is_removing(self) -> bool:
        return bool(self.modifiers & REMOVE_MODIFIER)

    @property
    def _paints_new_object(self) -> bool:
        """Whether a new object is painted."""
        return bool(self.modifiers & Qt.KeyboardModifier.ControlModifier) and not self._is_removing

    def _find_target(self, at: Place, reach: float) -> None:
        """Find the line or object that a press at a place would act on."""
        self._reach = max(reach, 1.0)
        self._item, self._held, self._obstacle = None, None, ""
        if self.volume is None:
            on = self._editing.find_boundary(at, self._reach)
            self._item, self._held = on if on is not None else (None, self._editing.find_contact(at, self._reach))
        if self._held is None:
            adds, makes_new = not self._is_removing, self._paints_new_object
            self._item = None if makes_new else self._brush.find_target((at,), self.radius, adds)
            self._obstacle = self._brush.find_obstacle(at, self._item, adds, makes_new)

    def _on_click(self, held: Contact, item: SegmentedObject | None) -> None:
        """Select the clicked object or contour, mark the place on the contour, or cut it there."""
        key = self._editing.key_of(held)
        if item is not None:
            self._list.select_objects((item.number,))
        elif self._is_removing:
            self._editing.cut_contour(held)
        elif self.modifiers & Qt.KeyboardModifier.ControlModifier:
            self._review.select(self._review.selected_keys ^ ({key} if key is not None else set()))
        else:
            if key is not None:
                self._review.select((key,))
            marked = self._editing.marked_places
            second = len(marked) == 1 and marked[0].is_on_same_contour(held) and marked[0].along != held.along
            self._editing.mark_places((*marked, held) if second else (held,))

    def _compute_edit(self, held: Contact) -> tuple[Sequence[HandEdit], Array, list[Position]]:
        """Compute the edits of a release now, the line that they add, and the places that are held and met."""
        at = self._pointer
        assert at is not None
        if not held.at_end:
            edit = pull_contour(held, at, None if self._is_removing else self._editing.edges)
            return (edit,), np.array(edit.added), [held.place]
        target = self._editing.find_contact(at, self._reach)
        if (
            target is not None
            and target.is_on_same_contour(held)
            and abs(target.along - held.along) <= 2.0 * self._reach
        ):
            target = None
        path = self._way(at if target is None else target.place)
        return connect_by_path(path, held, target), path, [held.place, *([] if target is None else [target.place])]

    def _show_preview(self) -> None:
        """Draw the preview, or the marks, the place under the pointer and the ring."""
        corners: list[Position] = [mark.place for mark in self._editing.marked_places]
        path: Sequence[Position] | Array = ()
        held, painting = self._held, self._brush.painting
        if self._dragged and held is not None and self._pointer is not None:
            _, path, corners = self._compute_edit(held)
        elif not painting:
            on_contour = held is not None and self._item is None
            self._review.set_hovered(self._editing.key_of(held) if held is not None and on_contour else None)
            marks = [*self._editing.marked_places, *([held] if held is not None and on_contour else [])][:2]
            if len(marks) == 2 and self._editing.marked_places and marks[0].is_on_same_contour(marks[1]):
                path = delete_stretch(*marks).removed
            corners += [held.place] if held is not None else []
        adds = self._brush.adds if painting else not self._is_removing
        self._drawing.show_draft(corners, path, theme.BY_HAND_COLOR)
        self._drawing.show_ring(
            self._pointer if held is None else None,
            self.radius,
            theme.RESTING_COLOR if adds else theme.BARRIER_COLOR,
            None if self.current_slice is None or self._brush.paints_in_space else self.current_slice.axis,
        )
        self._on_advice_changed()

    def _finish_gesture(self) -> None:
        self._brush.end_stroke()
        self._held = self._pressed = None
        self._dragged = False
        super().on_release()
        if self._pointer is not None:
            self._find_target(self._pointer, self._reach)
        self._show_preview()
