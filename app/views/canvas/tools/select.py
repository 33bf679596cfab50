"""The tool that selects, moves and reshapes."""

from __future__ import annotations

from app.model.document import edits
from app.model.document.hit_testing import hit
from app.model.document.naming import describe
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.tools.tool import Cursor, Momentary, new_gesture
from cpm_core.numerics.types import Position
from cpm_core.shapes import Circle, Shape


class SelectTool(Momentary):
    """Selects, moves and, by the handles, resizes."""

    name = "select"

    by_keys = tr("Enter takes hold of what lies under the cross-hair, arrow keys drag it, Enter lets go.")

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self._index: int | None = None
        self._part = ""
        self._anchor: Position = (0.0, 0.0)
        self._shape: Shape | None = None
        self._gesture = ""

    def press(self, at: Position, reach: float) -> None:
        """Select what lies under the pointer."""
        found = hit(self._session.document.shapes, at, reach, self._session.selected)
        self._index = found.index if found else None
        self._part = found.part if found else ""
        self._anchor = at
        self._shape = self._session.document.shapes[found.index] if found else None
        self._gesture = new_gesture("drag")
        self._session.select(self._index)

    def drag(self, at: Position) -> None:
        """Move the selected shape, or its rim or corner."""
        if self._shape is None:
            return
        by = (at[0] - self._anchor[0], at[1] - self._anchor[1])
        if self._part == "handle":
            self._replace(
                tr("reshape {shape}").format(shape=describe(self._shape)), self._shape.with_handle_at(self._anchor, at)
            )
        else:
            self._replace(tr("move {shape}").format(shape=describe(self._shape)), self._shape.moved(by))

    def release(self) -> None:
        """Leave the shape where it is."""
        self._shape = None
        self._session.seal()

    def cancel(self) -> None:
        """Put the shape back."""
        if self._shape is not None:
            self._replace(tr("move"), self._shape)
        self.release()

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A hand over what can be moved, arrows over a handle."""
        found = hit(self._session.document.shapes, at, reach, self._session.selected)
        if found is None:
            return Cursor.ArrowCursor
        shape = self._session.document.shapes[found.index]
        if found.part == "body" or not isinstance(shape, Circle):
            return Cursor.SizeAllCursor if found.part == "body" else Cursor.PointingHandCursor
        upright = abs(at[0] - shape.center[0]) > abs(at[1] - shape.center[1])
        return Cursor.SizeVerCursor if upright else Cursor.SizeHorCursor

    def grips(self, at: Position, reach: float) -> bool:
        """Whether a handle of the selected shape lies under the pointer."""
        found = hit(self._session.document.shapes, at, reach, self._session.selected)
        return found is not None and found.part == "handle"

    def _replace(self, name: str, shape: Shape) -> None:
        index = self._index
        if index is not None and index < len(self._session.document.shapes):
            self._session.edit(name, lambda document: edits.replace_shape(document, index, shape), self._gesture)
