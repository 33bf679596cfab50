"""The tool that selects: shapes, which it moves and reshapes, objects, proposals and contours."""

from __future__ import annotations

import operator

from PySide6.QtCore import Qt

from cpm_app.model.display.lengths import format_measured_length
from cpm_app.model.document.edits import ShapeHit
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr
from cpm_app.session.features.object_rows import ItemKey
from cpm_app.session.features.slices import hit_shape
from cpm_app.views.theme import theme
from cpm_app.views.tools.tool import Cursor, ShapeTool
from cpm_core.numerics import Place, Position
from cpm_core.shapes import Circle

_SELECTION_MODIFIERS = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier
"""Keys that change the selection instead of replacing it."""

_DESELECT_MODIFIER = Qt.KeyboardModifier.ControlModifier
"""Key that removes what lies in the frame from the selection."""


class SelectTool(ShapeTool):
    """Selects by a click, or by a frame around several items.

    A shape moves with the pointer, and its handles reshape it. A frame with Shift adds to the selection, with Ctrl
    removes from it; a click with either key toggles the item. In a volume, a click that hits no shape moves the cross.
    """

    name = "select"
    menu_text = tr("&Select tool")
    word = tr("Select")
    shortcut = "S"
    panel = "objects"
    tip = tr(
        "Click objects, contours or shapes to select them, or drag a frame around them; drag a shape to move it. "
        "{key:accept} accepts, {key:reject} rejects."
    )
    keyboard_tip = tr("Enter picks up what lies under the cross-hair, arrow keys move it, Enter puts it down.")

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        super().set_up()
        self._list = self._workspace.object_list
        self._part = ""
        self._anchor: Place = (0.0, 0.0)
        self._crossing = False
        self._corner: Position | None = None
        """Corner where the frame begins."""
        self._selected_before: frozenset[ItemKey] = frozenset()
        self._met_keys: frozenset[ItemKey] = frozenset()
        self._removes = False

    @property
    def advice(self) -> str:
        """Sentence on what can be done with the selection."""
        if self._corner is not None:
            return insert_keys(tr("Shift adds to the selection, Ctrl removes from it; {key:escape} cancels."))
        kinds = {row.kind for row in self._list.selected_rows}
        contours = self._workspace.contour_selection.selected_contours
        if contours and not kinds:
            image = self._session.image
            length = "" if image is None else format_measured_length(
                sum(contour.length for contour in contours), image.spacing, image.unit
            )  # fmt: skip
            words = tr("1 contour, {length} long") if len(contours) == 1 else tr("{count} contours, {length} long")
            return tr(
                "{contours}. Enter accepts as objects.", contours=words.format(count=len(contours), length=length)
            )
        if kinds == {"object"}:
            return insert_keys(tr("{key:name_object}: rename · 1-9: class · Delete: remove · {key:reject}: reject"))
        if kinds:
            return insert_keys(tr("Enter accepts · {key:reject} rejects · {key:name_object}: name · 1-9: class"))
        listed = self._list.rows or self._session.scene.contours
        return tr("Click to select, or drag a frame around several.") if listed else ""

    def on_press(self, at: Place) -> None:
        """Select the shape, object or contour under the pointer, or begin a frame."""
        self._selected_before = self._list.selected_keys
        found, key = self._find_item(at)
        self._session.select_shape(found.index if found is not None else None)
        if found is not None:
            self._begin_gesture(found.index)
            self._part, self._anchor = found.part, found.handle or at
            self._list.select_items(())
            return
        self._crossing = self.current_slice is not None
        self._met_keys = frozenset(() if key is None else (key,))
        self._removes = (
            key in self._selected_before
            if self.modifiers & _SELECTION_MODIFIERS
            else bool(self.modifiers & _DESELECT_MODIFIER)
        )
        self._corner = self.position_in_slice(at) if self.current_slice is None else None
        if key is not None:
            self._update_selection()
        self.on_drag(at)

    def on_drag(self, at: Place) -> None:
        """Move the selected shape, or its handle; or select what lies in the frame."""
        shape = self._before
        if self._crossing:
            self._workspace.slices.go_through(at)
        if self._frame:
            self._removes = bool(self.modifiers & _DESELECT_MODIFIER)
            self._met_keys = self._list.items_inside(self._frame)
            self._update_selection()
        if shape is None or at == self._anchor:
            return
        if self._part == "handle":
            self._put_shape(tr("reshape {shape}"), shape.with_handle_at(self._anchor, at))
        else:
            self._put_shape(tr("move {shape}"), shape.translated(tuple(map(operator.sub, at, self._anchor))))

    def on_release(self) -> None:
        """Keep the selection; a click outside all items clears it."""
        if self._before is None and not self._met_keys and not self.modifiers & _SELECTION_MODIFIERS:
            self._list.select_items(())
        self._end_frame()
        super().on_release()

    def cancel(self) -> None:
        """Restore the shape and the selection, and highlight nothing."""
        if self._corner is not None:
            known = {row.key for row in self._list.rows}
            self._list.select_items(key for key in self._selected_before if key in known or key[0] == "contour")
        self._end_frame()
        self._list.set_hovered_item(None)
        super().cancel()

    def hide_marks(self) -> None:
        """Highlight nothing."""
        super().hide_marks()
        self._list.set_hovered_item(None)

    def cursor_at(self, at: Place) -> Cursor:
        """Highlight the item under the pointer, and return arrows over a shape, a hand over another item."""
        found, key = self._find_item(at)
        self._list.set_hovered_item(key)
        if found is None:
            if key is not None:
                return Cursor.PointingHandCursor
            return Cursor.ArrowCursor if self.current_slice is None else Cursor.CrossCursor
        shape = self._session.document.shapes[found.index]
        if found.part == "body" or not isinstance(shape, Circle):
            return Cursor.SizeAllCursor if found.part == "body" else Cursor.PointingHandCursor
        upright = abs(at[0] - shape.center[0]) > abs(at[1] - shape.center[1])
        return Cursor.SizeVerCursor if upright else Cursor.SizeHorCursor

    def select_item_at(self, at: Place) -> bool:
        """Select the item at a place, unless it is selected already; return whether there is one."""
        found, key = self._find_item(at)
        self._session.select_shape(None if found is None else found.index)
        if found is not None:
            self._list.select_items(())
        elif key is not None and key not in self._list.selected_keys:
            self._list.select_items((key,))
        return found is not None or key is not None

    def has_handle_at(self, at: Place) -> bool:
        """Tell whether a handle of the selected shape lies under the pointer."""
        found = self._find_shape(at)
        return found is not None and found.part == "handle"

    def _find_item(self, at: Place) -> tuple[ShapeHit | None, ItemKey | None]:
        """Find the shape at a place, or else the row: lines before areas, the selected shape first."""
        found = self._find_shape(at)
        if found is not None:
            shape = self._session.document.shapes[found.index]
            selected = found.index == self._session.selected_shape
            if found.part == "handle" or selected or shape.distance_to(at) <= self.reach:
                return found, None
        key = self._list.item_at(at, self.reach)
        return (None, key) if key is not None else (found, None)

    def _find_shape(self, at: Place) -> ShapeHit | None:
        return hit_shape(self._session.scene, at, self.reach, self.current_slice)

    @property
    def _frame(self) -> tuple[Position, ...]:
        """Corners of the frame, once it is larger than a click."""
        if self._corner is None or self.pointer is None:
            return ()
        corner, at = self._corner, self.position_in_slice(self.pointer)
        if max(abs(at[0] - corner[0]), abs(at[1] - corner[1])) <= self.reach:
            return ()
        return corner, (corner[0], at[1]), at, (at[0], corner[1])

    def draw_marks(self) -> None:
        """Draw the frame."""
        self._drawing.show_draft((), (*self._frame, *self._frame[:1]), theme.SELECTED_COLOR)

    def _update_selection(self) -> None:
        """Combine the found items with the selection according to the modifier keys."""
        if self._removes:
            self._list.select_items(self._selected_before - self._met_keys)
        else:
            self._list.select_items(
                self._met_keys | self._selected_before if self.modifiers & _SELECTION_MODIFIERS else self._met_keys
            )

    def _end_frame(self) -> None:
        self._corner = None
        self._met_keys, self._crossing = frozenset(), False
