"""The outline tool: draws objects along the edges, anchor by anchor, or freehand."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from PySide6.QtCore import Qt

from cpm_app.model.text.language import tr
from cpm_app.session.features.outline_editing import HeldCurve, PathFinder
from cpm_app.views.theme import theme
from cpm_app.views.tools.tool import MIN_DRAWN_AREA, Cursor, Tool
from cpm_core.numerics import Array, Position, polyline
from cpm_core.reconstruction import replace_stretch, snap_path_to_ridge


class _Anchor(NamedTuple):
    """Place where the line is fixed, the click before snapping, and the piece of line that leads to the place."""

    place: Position
    click: Position
    piece: Array

    def is_near(self, place: Position, reach: float) -> bool:
        """Tell whether a click at a place is on this anchor."""
        return min(math.dist(place, self.place), math.dist(place, self.click)) <= reach


class OutlineTool(Tool):
    """Draws an object, open or closed: clicks set anchors, and the line between them follows the edges.

    With Shift the line is straight, a drag draws freehand. A line between two places of one outline replaces the
    stretch between them; a contour of the run becomes an object by that.
    """

    name = "outline"
    menu_text = tr("O&utline")
    shortcut = "U"
    panel = "objects"
    tip = tr(
        "Click along the boundary of an object: the line follows the edges, and becomes an object, open or closed."
    )
    works_by_clicks = True
    keyboard_tip = tr(
        "Enter sets an anchor; Enter once more on the first anchor closes the line, on the last one ends it."
    )

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        self._editing = self._workspace.outline_editing
        self._anchors: list[_Anchor] = []
        self._begin: HeldCurve | None = None
        self._trace: PathFinder | None = None

    @property
    def has_draft(self) -> bool:
        """Whether a line has been begun and not finished."""
        return bool(self._anchors)

    @property
    def advice(self) -> str:
        """Sentence on what to do next."""
        if not self._anchors:
            return "" if self.used else self.usage
        return tr(
            "Click the first anchor to close the line, Enter or a double click ends it; Shift draws a "
            "straight line, dragging draws freehand; Backspace removes the last anchor."
        )

    def on_press(self, at: Position) -> None:
        """Set an anchor; on the first one close the line, on the last one end it."""
        if len(self._anchors) > 1 and self._anchors[0].is_near(at, self.reach):
            place = self._anchors[0].place
            self._add_anchor(place, at, self._trace_piece(place))
            self.finish(closed=True)
        elif self._anchors and self._anchors[-1].is_near(at, self.reach):
            self.finish()
        else:
            place = self._snap_anchor(at)
            if not self._anchors:
                self._begin = self._find_curve(at)
            self._add_anchor(place, at, self._trace_piece(place))

    def on_release(self) -> None:
        """Keep the freehand line, and close it if it has returned to its beginning."""
        if not self.is_dragged or len(self.stroke) < 2:
            return
        at, first = self.stroke[-1], self._anchors[0]
        closes = first.is_near(at, self.reach)
        end = first.place if closes else self._snap_anchor(at)
        path = np.array([self._anchors[-1].place, *self.stroke[1:-1], end])
        edges = None if self._is_straight else self._editing.edges
        self._add_anchor(end, at, path if edges is None else snap_path_to_ridge(path, edges))
        if closes:
            self.finish(closed=True)

    def finish(self, closed: bool = False) -> None:
        """Turn the line into an object, or into a stretch of the outline on which it begins and ends."""
        begin, pieces = self._begin, self._pieces
        end = self._find_curve(self._anchors[-1].place) if pieces else None
        self.cancel()
        if not pieces:
            return
        path = np.concatenate([pieces[0], *(piece[1:] for piece in pieces[1:])])
        if closed and polyline.enclosed_area(path) < MIN_DRAWN_AREA:
            self.show_message(tr("That is too small for an outline. {advice}", advice=self.usage))
        elif not closed and begin is not None and end is not None and begin.is_on_same_curve(end):
            self._editing.redraw_curve(begin, replace_stretch(begin.place, end.place, path))
        else:
            number = self._editing.add_outline(path[:-1] if closed else path, closed)
            self._workspace.object_list.select_objects((number,))

    def remove_last_part(self) -> None:
        """Remove the last anchor."""
        if self._anchors:
            self._anchors.pop()
            self._trace = None
            self.update_marks()

    def cancel(self) -> None:
        """Discard the line."""
        self._anchors = []
        self._begin = self._trace = None
        super().cancel()

    def cursor_at(self, at: Position) -> Cursor:
        """Return a cross, and prepare the edges."""
        self._editing.request_edges()
        return Cursor.CrossCursor

    @property
    def _is_straight(self) -> bool:
        """Whether lines are straight, and freehand ones stay as they are."""
        return bool(self.modifiers & Qt.KeyboardModifier.ShiftModifier)

    @property
    def _pieces(self) -> list[Array]:
        return [anchor.piece for anchor in self._anchors[1:]]

    def _find_curve(self, at: Position) -> HeldCurve | None:
        """Find the outline that a line touches where it begins or ends."""
        return None if self._is_straight else self._editing.find_curve(at, 0.5 * self.reach)

    def _snap_anchor(self, at: Position) -> Position:
        """Snap a place to the outline or edge under the pointer; with Shift, keep it."""
        if self._is_straight:
            return at
        held = self._find_curve(at)
        return held.place.place if held is not None else self._editing.snap_to_edge(at)

    def _trace_piece(self, place: Position) -> Array:
        """Trace the line from the last anchor to a place, shape (K, 2), clear of the pieces drawn before."""
        begin = self._anchors[-1].place if self._anchors else place
        if self._is_straight or not self._anchors:
            return np.array([begin, place], dtype=float)
        self._trace = self._trace or self._editing.path_from(begin, self._pieces)
        return self._trace(place)

    def _add_anchor(self, place: Position, click: Position, piece: Array) -> None:
        self._anchors.append(_Anchor(place, click, piece))
        self._trace = None

    def draw_marks(self) -> None:
        """Draw the line as far as the pointer."""
        parts = self._pieces
        if self.is_dragged:
            parts.append(np.array([self._anchors[-1].place, *self.stroke[1:]]))
        elif self._anchors and self.pointer is not None and not self.stroke:
            parts.append(self._trace_piece(self._snap_anchor(self.pointer)))
        path = np.concatenate(parts) if parts else ()
        self._drawing.show_draft([anchor.place for anchor in self._anchors], path, theme.BY_HAND_COLOR)
