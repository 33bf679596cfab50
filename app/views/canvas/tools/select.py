"""The tool that selects, moves and reshapes."""

from __future__ import annotations

import operator

from app.model.document.edits import Hit
from app.model.text.language import from_core, tr
from app.session.features.slices import hit_in
from app.views.canvas.tools.tool import SELECT, Cursor, ShapeTool
from cpm_core.numerics import Place
from cpm_core.shapes import Circle


class SelectTool(ShapeTool):
    """Selects shapes, moves them, and reshapes them by their handles; where there is none, it moves the cross."""

    name = "select"
    text = tr("&Select")
    shortcut = "S"
    group = SELECT
    panel = "objects"
    tip = tr("Select, move and reshape what is drawn.")
    by_keys = tr("Enter picks up what lies under the cross-hair, arrow keys move it, Enter puts it down.")

    def set_up(self) -> None:
        """Set what it keeps between events."""
        super().set_up()
        self._part = ""
        self._anchor: Place = (0.0, 0.0)
        self._crossing = False

    def press(self, at: Place, reach: float) -> None:
        """Select the shape under the pointer."""
        found = self._hit(at, reach)
        if found is not None:
            self._begin(found.index)
            self._part, self._anchor = found.part, found.at or at
        self._session.select(found.index if found else None)
        self._crossing = found is None and self.here is not None
        self.drag(at)

    def drag(self, at: Place) -> None:
        """Move the selected shape, or its handle."""
        shape = self._before
        if self._crossing:
            self._workspace.slices.through(at)
        if shape is None or at == self._anchor:
            return
        if self._part == "handle":
            self._put(
                tr("reshape {shape}").format(shape=from_core(shape.title)), shape.with_handle_at(self._anchor, at)
            )
        else:
            by = tuple(map(operator.sub, at, self._anchor))
            self._put(tr("move {shape}").format(shape=from_core(shape.title)), shape.moved(by))

    def release(self) -> None:
        """Keep shape and cross as they are."""
        self._crossing = False
        super().release()

    def cursor(self, at: Place, reach: float) -> Cursor:
        """A four-way arrow over a shape, a hand or a two-way arrow over a handle."""
        found = self._hit(at, reach)
        if found is None:
            return Cursor.ArrowCursor if self.here is None else Cursor.CrossCursor
        shape = self._session.document.shapes[found.index]
        if found.part == "body" or not isinstance(shape, Circle):
            return Cursor.SizeAllCursor if found.part == "body" else Cursor.PointingHandCursor
        upright = abs(at[0] - shape.center[0]) > abs(at[1] - shape.center[1])
        return Cursor.SizeVerCursor if upright else Cursor.SizeHorCursor

    def grips(self, at: Place, reach: float) -> bool:
        """Whether a handle of the selected shape lies under the pointer."""
        found = self._hit(at, reach)
        return found is not None and found.part == "handle"

    def _hit(self, at: Place, reach: float) -> Hit | None:
        return hit_in(self._session.scene, at, reach, self.here)
