"""The tool that splits objects, the action `split_object`: an entry of the menu Objects next to merge."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtGui import QCursor

from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.views.theme import theme
from cpm_app.views.theme.icons import create_pointer
from cpm_app.views.tools.tool import Cursor, Tool
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
        self._preview = QTimer(self._list, singleShot=True, interval=_PREVIEW_DELAY)
        self._preview.timeout.connect(self._preview_cut)
        self._cut: Sequence[Place] | Array = ()
        """Cut that a click here would make."""

    @property
    def has_draft(self) -> bool:
        """Whether one half has been clicked."""
        return self._clicked_object is not None

    @property
    def advice(self) -> str:
        """Sentence on what the next click does."""
        if self._draws_line:
            return insert_keys(tr("Release to split along the line; {key:escape} cancels."))
        if self._clicked_object is not None:
            name = self._list.title_of(self._clicked_object)
            return insert_keys(tr("Click the other half of {name}; {key:escape} cancels."), name=name)
        return self.usage

    @property
    def _draws_line(self) -> bool:
        return self.is_dragged and self.volume is None

    def on_release(self) -> None:
        """Split along the line, or use the click, after all that was done before."""
        split = partial(self._split_along, self.stroke) if self._draws_line else partial(self._on_click, self.stroke[0])
        self._workspace.object_selection.do_in_order(split)

    def on_hover(self, at: Place) -> None:
        """Schedule the preview of a split here, for when the pointer rests."""
        self._preview.start()

    def remove_last_part(self) -> None:
        """Forget the first half."""
        self.cancel()

    def cancel(self) -> None:
        """Forget the first half, or the line."""
        self._clicked_object, self._cut = None, ()
        super().cancel()

    def hide_marks(self) -> None:
        """Hide the preview."""
        self._cut = ()
        super().hide_marks()

    def cursor_at(self, at: Place) -> Cursor | QCursor:
        """Return a knife, and prepare the edges."""
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
            self.show_message(tr("There is no object here. {advice}", advice=self.usage))

    def _split_along(self, path: list[Place]) -> None:
        places = polyline.path_midpoints(np.array(path), _SAMPLED_PLACES).tolist()
        crossed = [whole for row, col in places if (whole := self._find_object((row, col))) is not None]
        if crossed:
            most = max(crossed, key=lambda one: sum(item.number == one.number for item in crossed))
            self._apply_split(most, partial(split_object_along, most, path, self._editing.edges))
        else:
            self.show_message(tr("The line crosses no object. {advice}", advice=self.tip))

    def _apply_split(self, whole: SegmentedObject, halves: Callable[[], Halves], at: Place = ()) -> None:
        """Replace an object by its halves, or report why that fails; in a volume, split it at a place."""
        self._clicked_object, self._cut = None, ()
        if whole.frozen:
            self.show_message(tr("{name} is frozen: unfreeze it to split it.", name=self._list.title_of(whole)))
            return
        try:
            if whole.region.ndim == 3:
                self._commands.split_object_in_volume(whole, self._first, at)
            else:
                self._commands.split_object(whole, halves())
        except ValueError as error:
            self.show_message(translate_core_text(str(error)))

    def _find_object(self, at: Place) -> SegmentedObject | None:
        """Find the object or proposal around a place: a selected one first, then the smallest object."""
        under = ("object", self._list.object_number_at(at))
        key = under if under[1] else self._list.item_at(at, 0.0)
        rows = (*self._list.selected_rows, *(row for row in self._list.rows if row.key == key))
        return next((row.item for row in rows if not row.item.hidden and row.item.region.contains(at)), None)

    def draw_marks(self) -> None:
        """Draw the line, or the clicked half and the cut that a click here would make."""
        marked = [self._first] if self._clicked_object is not None else ()
        self._drawing.show_draft(marked, self.stroke if self._draws_line else self._cut, theme.BARRIER_COLOR)

    def _preview_cut(self) -> None:
        """Find the cut that a click at the pointer would make."""
        whole, at, self._cut = self._clicked_object, self.pointer, ()
        if not (self.volume or whole is None or at is None) and whole.region.contains(at):
            with suppress(ValueError):
                cuts = split_object(whole, self._first, at, self._editing.edges).cuts
                self._cut = max(cuts, key=len, default=())
        self.update_marks()
