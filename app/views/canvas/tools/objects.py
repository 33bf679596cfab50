"""The tool that selects objects by clicks."""

from __future__ import annotations

import math

from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.views.canvas.tools.tool import OBJECT, TAKING_AWAY, Cursor, Tool
from app.views.theme import theme
from cpm_core.numerics import Place

_APART = 3.0
"""Least distance between two places of a stroke [px]."""

_MOST = 200
"""Largest number of places of a stroke; a longer one is thinned out."""


class ObjectTool(Tool):
    """Selects the object under the pointer; with Shift a click says what does not belong to it.

    A stroke says the same of all that it crosses. Enter accepts the object; a click on an accepted object
    changes it.
    """

    name = "objects"
    text = tr("Ob&jects")
    shortcut = "W"
    group = OBJECT
    panel = "objects"
    tip = tr("Click in an object to select it, Shift-click to remove what does not belong to it; Enter accepts it.")
    by_keys = tr("Enter clicks, Shift+Enter removes what does not belong to the object; Ctrl+Enter accepts it.")
    clicks = True
    lasting = True

    def set_up(self) -> None:
        """Set what it keeps between events."""
        self._selection, self._list = self._workspace.object_selection, self._workspace.object_list
        self._path: list[Place] = []

    @property
    def drafting(self) -> bool:
        """Whether an object is being selected, or one is offered."""
        return self._selection.selecting or bool(self._selection.proposals)

    @property
    def advice(self) -> str:
        """What to do next."""
        if not self._selection.ready:
            if self.volume is not None and self._session.status.surface is None:
                return tr("Let a run find the surface first: objects are the bodies that it encloses.")
            return ""
        if self._selection.selecting:
            return with_keys(tr("Click to add, Shift-click to remove. Enter accepts, {key:escape} cancels."))
        if self._selection.proposals:
            return with_keys(
                tr("Enter accepts what was found. Click to add, Shift-click to remove, {key:escape} discards it.")
            )
        if self._list.chosen:
            return tr("Enter: rename · 1-9: class · Delete: remove. Click in the next object.")
        return tr("Click in an object, or drag across it.")

    def set_in_use(self, in_use: bool) -> None:
        """Let the image be prepared while the tool is in use."""
        self._selection.set_in_use(in_use)

    def press(self, at: Place, reach: float) -> None:
        """Begin a click or a stroke, or change the object under the pointer if none is being selected."""
        self.used = True
        existing = self._existing(at)
        if existing:
            self._list.begin_change(existing)
        else:
            self._path = [at]

    def drag(self, at: Place) -> None:
        """Continue a stroke."""
        if self._path and math.dist(self._path[-1], at) >= _APART:
            self._path.append(at)
            color = theme.RESTING if self._inside else theme.BARRIER
            self._drawing.show_draft((), self._path, color)

    def release(self) -> None:
        """Say that the places of the click or stroke are inside, or outside."""
        path = tuple(self._path)
        self._end_stroke()
        if not path:
            return
        if not self._selection.selecting:
            self._list.choose(())
        self._selection.click(path[:: math.ceil(len(path) / _MOST)], self._inside)

    def hover(self, at: Place) -> None:
        """Show what a click would take."""
        existing = self._existing(at)
        self._list.hover(("object", existing) if existing else None)
        self._selection.point(None if existing else at, self._inside)

    def finish(self) -> None:
        """Accept the object."""
        self._list.accept()

    def take_back(self) -> None:
        """Take back the last click."""
        self._selection.take_back()

    def cancel(self) -> None:
        """Drop the stroke, or what is being selected."""
        if self._path:
            self._end_stroke()
        else:
            self._selection.drop()

    def put_away(self) -> None:
        """Hide what a click would take."""
        self._list.hover(None)
        self._selection.point(None)

    def cursor(self, at: Place, reach: float) -> Cursor:
        """A hand over an object that a click would change."""
        return Cursor.PointingHandCursor if self._existing(at) else Cursor.CrossCursor

    @property
    def _inside(self) -> bool:
        """Whether a click adds: with Shift it says what does not belong to the object."""
        return not self.modifiers & TAKING_AWAY

    def _existing(self, at: Place) -> int:
        """Number of the object that a click would change; 0 while another one is being selected."""
        return 0 if self._selection.selecting or not self._inside else self._list.under(at)

    def _end_stroke(self) -> None:
        self._path = []
        self._drawing.show_draft()
