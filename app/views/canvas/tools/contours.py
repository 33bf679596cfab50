"""The tool that selects contours."""

from __future__ import annotations

import math

import numpy as np
from PySide6.QtCore import Qt

from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.views.canvas.tools.tool import SELECT, Cursor, Tool
from app.views.theme import theme
from cpm_core.numerics import Position

_ADDING = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier
_REMOVING = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.AltModifier
_MOST_STEPS = 200
"""Most places along one move of the pointer at which contours are looked for."""


class ContourTool(Tool):
    """Selects contours by a click, by a frame that is dragged from an empty place, or by a drag from one across others.

    A frame with Shift adds to the selection, one with Ctrl removes from it. A click or a stroke with either of them
    removes what it meets if it begins on a selected contour, and adds it otherwise.
    """

    name = "contours"
    text = tr("C&ontours")
    shortcut = "V"
    group = SELECT
    panel = "objects"
    tip = tr(
        "Click contours, drag a frame around them, or drag across them to select; {key:reject} rejects, "
        "{key:keep} keeps."
    )
    clicks = True
    by_keys = tr("Enter selects the contour under it.")

    def set_up(self) -> None:
        """Set what it keeps between events."""
        self._review = self._workspace.review
        self._reach = 0.0
        self._corner: Position | None = None
        """Where a frame begins."""
        self._last: Position | None = None
        """Where the pointer was last on its way across contours."""
        self._before: frozenset[int] = frozenset()
        self._found: frozenset[int] = frozenset()
        self._removes = False

    @property
    def advice(self) -> str:
        """What can be done with contours."""
        if self._corner is not None or self._last is not None:
            return with_keys(tr("Shift adds to the selection, Ctrl removes from it; {key:escape} cancels."))
        if self._review.selected:
            return with_keys(
                tr(
                    "{key:reject} rejects, {key:keep} keeps, Enter names; Shift adds to the selection, "
                    "Ctrl removes from it."
                )
            )
        return tr("Click a contour to select it, or drag a frame around several.") if self._review.items else ""

    def press(self, at: Position, reach: float) -> None:
        """Select the contour under the pointer, or begin a frame."""
        key = self._review.under(at, reach)
        self._before, self._reach = self._review.selected, reach
        if key is None:
            self._corner, self._found = at, frozenset()
            return
        self._last, self._found = at, frozenset((key,))
        self._removes = key in self._before if self.modifiers & _ADDING else bool(self.modifiers & _REMOVING)
        self._show()

    def drag(self, at: Position) -> None:
        """Select what lies in the frame, or what the pointer crosses."""
        if self._corner is not None:
            corner = self._corner
            frame = (corner, (corner[0], at[1]), at, (at[0], corner[1]))
            self._removes = bool(self.modifiers & _REMOVING)
            self._found = self._review.within(frame)
            self._drawing.show_draft((), (*frame, corner), theme.CHOSEN)
            self._show()
        elif self._last is not None:
            steps = math.dist(self._last, at) / max(0.5 * self._reach, 1e-9)
            way = np.linspace(self._last, at, 2 + min(int(steps), _MOST_STEPS))
            keys = (self._review.under((float(row), float(col)), 0.5 * self._reach) for row, col in way)
            self._found |= {key for key in keys if key is not None}
            self._last = at
            self._show()

    def release(self) -> None:
        """Keep the selection; a click next to all contours removes it."""
        if self._corner is not None and not self._found and not self.modifiers & (_ADDING | _REMOVING):
            self._review.select(())
        self._end()

    def cancel(self) -> None:
        """Select what was selected before, and highlight no contour."""
        if self._corner is not None or self._last is not None:
            self._review.select(key for key in self._before if key in self._review)
            self._end()
        self._review.hover(None)

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A hand over a contour, which is also highlighted: the canvas asks after each move of the pointer."""
        key = self._review.under(at, reach)
        self._review.hover(key)
        return Cursor.ArrowCursor if key is None else Cursor.PointingHandCursor

    def _show(self) -> None:
        """Select what has been found, as the modifier keys tell."""
        if self._removes:
            self._review.select(self._before - self._found)
        else:
            self._review.select(self._found | self._before if self.modifiers & _ADDING else self._found)
        self._advised()

    def _end(self) -> None:
        self._corner = self._last = None
        self._found = frozenset()
        self._drawing.show_draft()
        self._advised()
