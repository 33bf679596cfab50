"""The tool that edits contours by hand: joins, closes, pulls, cuts, and marks stretches."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from PySide6.QtCore import Qt

from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.views.canvas.tools.tool import MEND, TAKING_AWAY, Cursor, Tool
from app.views.theme import theme
from cpm_core.contours import HandEdit
from cpm_core.numerics import Array, Position
from cpm_core.reconstruction import Contact, connect

_STILL = 0.5
"""Move of the pointer, in reaches, up to which a press is a click and not a drag."""


class EditContoursTool(Tool):
    """Drags ends and stretches of contours; clicks mark places on them, with Shift they cut.

    What a release would do is drawn as a preview.
    """

    name = "edit_contours"
    text = tr("&Mend")
    shortcut = "J"
    group = MEND
    panel = "objects"
    tip = tr("Drag an end of a contour to another end to join them, or a stretch to move it; Shift-click cuts.")
    by_keys = tr("Enter picks up, arrow keys move, Enter puts down; twice on one place marks it.")

    def set_up(self) -> None:
        """Set what it keeps between events."""
        self._editing, self._review = self._workspace.hand_editing, self._workspace.review
        self._held: Contact | None = None
        self._pressed: Position | None = None
        self._pointer: Position | None = None
        self._dragged = False
        self._way = self._editing.way_from((0.0, 0.0))
        self._reach = 1.0
        self._editing.changed.connect(self._show)

    @property
    def drafting(self) -> bool:
        """Whether places are marked."""
        return bool(self._editing.marked)

    @property
    def advice(self) -> str:
        """What can be done now."""
        if self._dragged and self._held is not None:
            if self._held.at_end:
                return with_keys(tr("Let go on another end to join; anywhere else to extend. {key:escape} cancels."))
            return with_keys(
                tr("Let go to redraw this stretch along the edge; with Shift it only bends. {key:escape} cancels.")
            )
        if len(self._editing.marked) == 2:
            return with_keys(tr("Delete removes the stretch between the marks; {key:escape} removes the marks."))
        if self._editing.marked:
            return tr("Click a second place on this contour to mark a stretch.")
        if not self._review.items:
            return tr("There are no contours to edit yet: let the particles run, or draw one with the outline tool.")
        return tr("Drag an end to another end, or drag a stretch. Click to mark a place, Shift-click to cut.")

    def press(self, at: Position, reach: float) -> None:
        """Take hold of the contour under the pointer."""
        self.used = True
        self._reach, self._pressed, self._dragged = max(reach, 1.0), at, False
        self._held = self._editing.contact(at, self._reach)
        if self._held is not None and self._held.at_end:
            self._way = self._editing.way_from_end(self._held)

    def drag(self, at: Position) -> None:
        """Show what letting go here would do."""
        self._pointer = at
        if self._held is None or self._pressed is None:
            return
        self._dragged = self._dragged or math.dist(self._pressed, at) > _STILL * self._reach
        self._show()

    def release(self) -> None:
        """Carry out what the preview shows, or mark the place that was clicked."""
        held, dragged = self._held, self._dragged
        edits = self._meant()[0] if dragged and held is not None else ()
        self._end()
        if edits:
            self._editing.add(edits)
        elif not dragged:
            self._click(held)

    def hover(self, at: Position) -> None:
        """Show the place that a press would take hold of."""
        self._pointer = at
        self._show()

    def finish(self) -> None:
        """Keep the marks: they are what keys and menus act on."""

    def take_back(self) -> None:
        """Delete the marked stretch, or remove a single mark."""
        if len(self._editing.marked) == 2:
            self._editing.delete_stretch()
        else:
            self._editing.mark(())

    def cancel(self) -> None:
        """Give up the drag, or remove the marks."""
        if self._pressed is None:
            self._editing.mark(())
        self._end()

    def put_away(self) -> None:
        """Hide the preview and the marks."""
        self._pointer = None
        self._review.hover(None)
        self._drawing.show_draft()

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A cross over an end, a hand elsewhere on a contour; the edges are prepared as soon as the tool is taken."""
        self._editing.prepare()
        self._reach = max(reach, 1.0)
        contact = self._editing.contact(at, self._reach)
        if contact is None:
            return Cursor.ArrowCursor
        return Cursor.CrossCursor if contact.at_end else Cursor.OpenHandCursor

    def _click(self, held: Contact | None) -> None:
        """Select the contour that was clicked and mark the place on it, or cut it there."""
        if held is None:
            self._editing.mark(())
            self._review.select(())
            return
        key = self._editing.key_of(held)
        if self.modifiers & TAKING_AWAY:
            self._editing.cut(held)
        elif self.modifiers & Qt.KeyboardModifier.ControlModifier:
            self._review.select(self._review.selected ^ {key} if key is not None else self._review.selected)
        else:
            if key is not None:
                self._review.select((key,))
            marked = self._editing.marked
            second = len(marked) == 1 and marked[0].same_contour(held) and marked[0].along != held.along
            self._editing.mark((*marked, held) if second else (held,))

    def _meant(self) -> tuple[Sequence[HandEdit], Array, list[Position]]:
        """What letting go now would do: the edits, the line that they add, and the places that are held and met."""
        held, at = self._held, self._pointer
        assert held is not None and at is not None
        if not held.at_end:
            edit = self._editing.pulled(held, at, not self.modifiers & Qt.KeyboardModifier.ShiftModifier)
            return (edit,), np.array(edit.added), [held.place]
        target = self._editing.contact(at, self._reach)
        if target is not None and target.same_contour(held) and abs(target.along - held.along) <= 2.0 * self._reach:
            target = None
        path = self._way(at if target is None else target.place)
        return connect(path, held, target), path, [held.place, *([] if target is None else [target.place])]

    def _show(self) -> None:
        """Draw the preview, or the marks and the place under the pointer."""
        corners: list[Position] = [mark.place for mark in self._editing.marked]
        path: Sequence[Position] | Array = ()
        if self._dragged and self._held is not None and self._pointer is not None:
            _, path, corners = self._meant()
        else:
            under = self._editing.contact(self._pointer, self._reach) if self._pointer is not None else None
            self._review.hover(self._editing.key_of(under) if under is not None else None)
            marks = [*self._editing.marked, *([under] if under is not None else [])][:2]
            if len(marks) == 2 and self._editing.marked and marks[0].same_contour(marks[1]):
                path = self._editing.stretch(*marks)
            corners += [under.place] if under is not None else []
        self._drawing.show_draft(corners, path, theme.BY_HAND)
        self._advised()

    def _end(self) -> None:
        self._held = self._pressed = None
        self._dragged = False
        self._show()
