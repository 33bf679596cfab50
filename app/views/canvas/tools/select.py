"""The tool that selects, moves and reshapes."""

from __future__ import annotations

import operator

from app.model.document.hit_testing import Hit
from app.model.document.naming import describe
from app.model.text.language import tr
from app.session.features.volumes.hits import hit_in
from app.views.canvas.tools.tool import Cursor, ShapeTool, ToolContext
from cpm_core.numerics.types import Position
from cpm_core.shapes import Circle


class SelectTool(ShapeTool):
    """Selects shapes, moves them, and reshapes them by their handles."""

    name = "select"
    tip = tr("Select, move and reshape what is drawn.")
    by_keys = tr("Enter picks up what lies under the cross-hair, arrow keys move it, Enter puts it down.")

    def __init__(self, context: ToolContext) -> None:
        super().__init__(context)
        self._part = ""
        self._anchor: Position = (0.0, 0.0)

    def press(self, at: Position, reach: float) -> None:
        """Select the shape under the pointer."""
        found = self._hit(at, reach)
        if found is not None:
            self._begin(found.index)
            self._part, self._anchor = found.part, at
        self._session.select(found.index if found else None)

    def drag(self, at: Position) -> None:
        """Move the selected shape, or its handle."""
        shape = self._before
        if shape is None:
            return
        if self._part == "handle":
            self._put(tr("reshape {shape}").format(shape=describe(shape)), shape.with_handle_at(self._anchor, at))
        else:
            by = tuple(map(operator.sub, at, self._anchor))
            self._put(tr("move {shape}").format(shape=describe(shape)), shape.moved(by))

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A four-way arrow over a shape, a hand or a two-way arrow over a handle."""
        found = self._hit(at, reach)
        if found is None:
            return Cursor.ArrowCursor
        shape = self._session.document.shapes[found.index]
        if found.part == "body" or not isinstance(shape, Circle):
            return Cursor.SizeAllCursor if found.part == "body" else Cursor.PointingHandCursor
        upright = abs(at[0] - shape.center[0]) > abs(at[1] - shape.center[1])
        return Cursor.SizeVerCursor if upright else Cursor.SizeHorCursor

    def grips(self, at: Position, reach: float) -> bool:
        """Whether a handle of the selected shape lies under the pointer."""
        found = self._hit(at, reach)
        return found is not None and found.part == "handle"

    def _hit(self, at: Position, reach: float) -> Hit | None:
        return hit_in(self._session.scene, at, reach)
