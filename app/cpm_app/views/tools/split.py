"""The tool that splits objects, the action `split_object`: an entry of the menu Objects next to merge."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtGui import QCursor

from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.session.session_messages import EDITING_CATEGORY
from cpm_app.views.theme import theme
from cpm_app.views.theme.icons import create_pointer
from cpm_app.views.tools.tool import FREEHAND_SPACING, MEND_GROUP, Cursor, Tool
from cpm_core.numerics import Array, Place, polyline
from cpm_core.objects.segmented import Halves, SegmentedObject, split_object, split_object_along

_SAMPLED_PLACES = 16
"""Number of places along a line that are searched for objects."""

_PREVIEW_DELAY = 40
"""Time without a move of the pointer after which the preview is drawn [ms]."""


class SplitTool(Tool):
    """Splits objects and proposals between two clicks or along a line."""

    name = "split"
    menu_text = tr("Spli&t")
    shortcut = "K"
    group = MEND_GROUP
    panel = "objects"
    tip = tr("Click one half of an object, then the other, or drag a line across it.")
    works_by_clicks = True
    keyboard_tip = tr("Enter in one half, then in the other.")

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        self._editing, self._list = self._workspace.outline_editing, self._workspace.object_list
        self._commands = self._workspace.object_commands
        self._clicked_object: SegmentedObject | None = None
        """Object with one half clicked."""
        self._first: Place = (0.0, 0.0)
        self._path: list[Place] = []
        self._at: Place | None = None
        self._reach, self._dragged = 1.0, False
        self._preview = QTimer(self._list, singleShot=True, interval=_PREVIEW_DELAY)
        self._preview.timeout.connect(self._show_preview)

    @property
    def has_draft(self) -> bool:
        """Whether one half has been clicked."""
        return self._clicked_object is not None

    @property
    def advice(self) -> str:
        """Sentence on what the next click does."""
        if self._dragged:
            return insert_keys(tr("Release to split along the line; {key:escape} cancels."))
        if self._clicked_object is not None:
            name = self._list.title_of(self._clicked_object)
            return insert_keys(tr("Click the other half of {name}; {key:escape} cancels."), name=name)
        return self._usage

    @property
    def _usage(self) -> str:
        """Sentence on how to split here; in a volume only clicks do."""
        by_clicks = tr("Click one half of an object, then the other: it is split at the neck between them.")
        return self.tip if self.volume is None else by_clicks

    def on_press(self, at: Place, reach: float) -> None:
        """Begin a click or a line."""
        self.used, self._reach = True, max(reach, 1.0)
        self._path, self._dragged = [at], False

    def on_drag(self, at: Place) -> None:
        """Draw a line."""
        if self._path and self.volume is None and math.dist(self._path[-1], at) >= FREEHAND_SPACING:
            self._path.append(at)
            self._dragged = self._dragged or math.dist(self._path[0], at) > self._reach
            self._show_preview()

    def on_release(self) -> None:
        """Split along the line, or use the click."""
        path, dragged = self._path, self._dragged
        self._path, self._dragged = [], False
        if dragged:
            self._split_along(path)
        elif path:
            self._on_click(path[0])
        self._show_preview()

    def on_hover(self, at: Place) -> None:
        """Schedule the preview of a split here, for when the pointer rests."""
        self._at = at
        self._preview.start()
        self._on_advice_changed()

    def remove_last_part(self) -> None:
        """Forget the first half."""
        self.cancel()

    def cancel(self) -> None:
        """Forget the first half, or the line."""
        self._clicked_object = None
        self._path, self._dragged = [], False
        self._show_preview()

    def hide_marks(self) -> None:
        """Hide the preview."""
        self._at = None
        self._show_preview()

    def cursor_at(self, at: Place, reach: float) -> Cursor | QCursor:
        """Return a knife, and prepare the edges."""
        self._reach = max(reach, 1.0)
        if self.volume is None:
            self._editing.request_edges()
        return create_pointer("knife")

    def _on_click(self, at: Place) -> None:
        first, whole = self._clicked_object, self._find_object(at)
        if first is not None and first.region.contains(at):
            self._apply_split(first, partial(split_object, first, self._first, at, self._editing.edges), at)
        elif whole is not None:
            self._clicked_object, self._first = whole, at
        else:
            self._session.messages.show(
                tr("There is no object here. {advice}", advice=self._usage), category=EDITING_CATEGORY
            )

    def _split_along(self, path: list[Place]) -> None:
        places = polyline.path_midpoints(np.array(path), _SAMPLED_PLACES).tolist()
        crossed = [whole for row, col in places if (whole := self._find_object((row, col))) is not None]
        if crossed:
            most = max(crossed, key=lambda one: sum(item.number == one.number for item in crossed))
            self._apply_split(most, partial(split_object_along, most, path, self._editing.edges))
        else:
            self._session.messages.show(
                tr("The line crosses no object. {advice}", advice=self.tip), category=EDITING_CATEGORY
            )

    def _apply_split(self, whole: SegmentedObject, halves: Callable[[], Halves], at: Place = ()) -> None:
        """Replace an object by its halves, or report why that fails; in a volume, split it at a place."""
        self._clicked_object = None
        if whole.frozen:
            name = self._list.title_of(whole)
            self._session.messages.show(
                tr("{name} is frozen: unfreeze it to split it.", name=name), category=EDITING_CATEGORY
            )
            return
        try:
            if whole.region.ndim == 3:
                self._commands.split_object_in_volume(whole, self._first, at)
            else:
                self._commands.split_object(whole, halves())
        except ValueError as error:
            self._session.messages.show(translate_core_text(str(error)), category=EDITING_CATEGORY)

    def _find_object(self, at: Place) -> SegmentedObject | None:
        """Find the object or proposal around a place: a selected one first, then the smallest object."""
        under = ("object", self._list.object_number_at(at))
        key = under if under[1] else self._list.item_at(at, 0.0)
        rows = (*self._list.selected_rows, *(row for row in self._list.rows if row.key == key))
        return next((row.item for row in rows if not row.item.hidden and row.item.region.contains(at)), None)

    def _show_preview(self) -> None:
        """Draw the line, or the clicked half and the cut that a click here would make."""
        path: Sequence[Place] | Array = self._path if self._dragged else ()
        whole, at = self._clicked_object, self._at
        if not (self._dragged or self.volume or whole is None or at is None) and whole.region.contains(at):
            with suppress(ValueError):
                cuts = split_object(whole, self._first, at, self._editing.edges).cuts
                path = max(cuts, key=len, default=())
        self._drawing.show_draft([self._first] if whole is not None else (), path, theme.BARRIER_COLOR)
        self._on_advice_changed()
