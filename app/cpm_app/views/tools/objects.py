"""The tool that selects objects by clicks."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from PySide6.QtCore import Qt

from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.views.theme import theme
from cpm_app.views.tools.tool import REMOVE_MODIFIER, Cursor, Tool
from cpm_core.field.start_area.drawn_area import MIN_DRAWN_PLACES, is_closed_line
from cpm_core.numerics import Place, polyline
from cpm_core.objects.segmented import Click

_MAX_STROKE_PLACES = 200
"""Largest number of places of a stroke."""


class ObjectTool(Tool):
    """Selects the object under the pointer; a click with Shift marks what does not belong to it.

    A stroke is a click on everything that it crosses. A click in an object, or in one of several proposals, selects it,
    and in the selected one begins a correction; with Ctrl it selects another object there. Enter accepts the proposal.
    """

    name = "objects"
    menu_text = tr("Ob&jects")
    shortcut = "W"
    panel = "objects"
    tip = tr("Click in an object to select it, Shift-click to remove what does not belong to it; Enter accepts it.")
    keyboard_tip = tr("Enter clicks, Shift+Enter removes what does not belong to the object; Ctrl+Enter accepts it.")
    works_by_clicks = True
    stroke_spacing = 3.0
    keeps_draft = True

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        self._selection, self._list = self._workspace.object_selection, self._workspace.object_list
        self._adds, self._wants_another = True, False

    @property
    def has_draft(self) -> bool:
        """Whether an object is being selected."""
        return self._selection.selecting

    @property
    def is_resizable(self) -> bool:  # type: ignore[override]
        """Whether there is an object to make smaller or larger."""
        return self.has_draft or bool(self._selection.proposals or self._list.selected_numbers)

    @property
    def advice(self) -> str:
        """Sentence on what to do next."""
        if self.volume is not None and self._session.scene.objects.awaited:
            return tr("Finding the body…")
        if not self._selection.ready:
            return ""
        if self._selection.selecting:
            return insert_keys(
                tr(
                    "Click to add, Shift-click to remove, [ ] for smaller and larger. Enter accepts, {key:escape} "
                    "cancels."
                )
            )
        if self._list.selected_numbers:
            return insert_keys(
                tr(
                    "Click in it: correct · Ctrl-click: another object here · {key:name_object}: rename · "
                    "1-9: class · Delete: remove"
                )
            )
        return "" if self._selection.proposals else tr("Click in an object, or drag across it.")

    def set_in_use(self, in_use: bool) -> None:
        """Keep the image prepared, and without the dots of starts everywhere, while the tool is in use."""
        self._drawing.hide_computed(in_use)
        self._selection.set_in_use(in_use)

    def on_press(self, at: Place) -> None:
        """Begin a click or a stroke."""
        self._adds, self._wants_another = self._is_positive, self._is_for_another

    def draw_marks(self) -> None:
        """Draw the stroke."""
        self._drawing.show_draft((), self.stroke, theme.RESTING_COLOR if self._adds else theme.BARRIER_COLOR)

    def on_release(self) -> None:
        """Do what the click or stroke means, after all that was done before."""
        places, begins = self._collect_places(), not self._selection.selecting
        if places:
            click = Click(places, self._adds)
            self._selection.do_in_order(partial(self._do_click, click, self._wants_another), click, needs_answer=begins)
        elif begins:  # in the margin there is nothing, as beside objects with the tool Select
            self._selection.do_in_order(partial(self._list.select_objects, ()))

    def _collect_places(self) -> tuple[Place, ...]:
        """Spread places along the stroke: all of a lasso, of another stroke those in the image; none in the margin."""
        places = _spread_places(self.stroke, self.stroke_spacing)
        within = tuple(filter(self.is_in_image, self.stroke))
        flat = np.array(places, float)
        if self.current_slice is not None:
            flat = self.current_slice.project_points(flat)
        if within and is_closed_line(flat):
            return places
        return within and (tuple(filter(self.is_in_image, places)) or within)

    def _do_click(self, click: Click, another: bool) -> None:
        """Select the object under a click, correct it if it is selected, or add the click to the object in progress."""
        first = next(filter(self.is_in_image, click.places))
        existing = 0 if another or not click.inside else self._find_existing(first)
        offered = [each.key for each in self._selection.proposals]
        if self._session.scene.objects.selected == {existing} or (existing and offered == [existing]):
            self._selection.correct_object(existing)
        elif existing:
            self._list.select_objects((existing,))
        else:
            if not self._selection.selecting:
                self._list.select_objects(())
            self._selection.add_click(click, another)

    def on_hover(self, at: Place) -> None:
        """Preview what a click would select or change."""
        existing = self._find_selectable(at)
        self._list.set_hovered_item(("object" if existing > 0 else "proposal", existing) if existing else None)
        place = None if existing or not self.is_in_image(at) else at
        self._selection.preview_click(place, self._is_positive, self._is_for_another)

    def resize_by(self, by: float) -> None:
        """Propose the next larger candidate, or the next smaller one."""
        self._selection.do_in_order(partial(self._selection.step_candidate, 1 if by > 0 else -1))

    def finish(self) -> None:
        """Accept the object; an Enter right after the click waits for the answer."""
        self._selection.accept()

    def remove_last_part(self) -> None:
        """Remove the last click."""
        self._selection.do_in_order(self._selection.undo_click, needs_answer=False)

    def cancel(self) -> None:
        """Drop the stroke, or the selection in progress."""
        if self.stroke:
            super().cancel()
        else:
            self._selection.do_in_order(self._selection.discard_clicks, needs_answer=False)

    def hide_marks(self) -> None:
        """Hide the preview of a click."""
        super().hide_marks()
        self._list.set_hovered_item(None)
        self._selection.preview_click(None)

    def cursor_at(self, at: Place) -> Cursor:
        """Return a hand over an object that a click would select, a cross elsewhere."""
        return Cursor.PointingHandCursor if self._find_selectable(at) else Cursor.CrossCursor

    @property
    def _is_positive(self) -> bool:
        """Whether a click adds a positive point; with Shift it adds a negative one."""
        return not self.modifiers & REMOVE_MODIFIER

    @property
    def _is_for_another(self) -> bool:
        """Whether a click in an object is for another one there; with Ctrl it is."""
        return bool(self.modifiers & Qt.KeyboardModifier.ControlModifier)

    def _find_selectable(self, at: Place) -> int:
        """Find the number of the object, or key of the proposal, that a click now would select; 0 if none."""
        return 0 if self._is_for_another or not self._is_positive else self._find_existing(at)

    def _find_existing(self, at: Place) -> int:
        """Find the number of the object, or key of the proposal, at a place; 0 while an object is being selected."""
        return 0 if self._selection.selecting else self._selection.object_number_at(at)


def _spread_places(stroke: Sequence[Place], spacing: float) -> tuple[Place, ...]:
    """Spread places evenly along a stroke, since what it means depends on its shape, not on how fast it was drawn."""
    path = np.array(stroke, float)
    length = polyline.path_length(path)
    if not length:
        return (stroke[0],)
    spacing = min(max(spacing, length / _MAX_STROKE_PLACES), length / MIN_DRAWN_PLACES)
    return polyline.as_line(polyline.resample_path(path, spacing))
