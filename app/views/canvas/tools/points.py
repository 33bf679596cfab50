"""The tool that places points."""

from __future__ import annotations

from app.model.document import edits
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.tools.tool import Momentary, new_gesture
from cpm_core.numerics.types import Position
from cpm_core.shapes import Points


class PointTool(Momentary):
    """Places a point, which follows the pointer for as long as the button is down."""

    name = "points"
    clicks = True
    by_keys = tr("Enter places a point.")

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self._index: int | None = None
        self._gesture = ""

    def press(self, at: Position, reach: float) -> None:
        """Place a point."""
        self._index = len(self._session.document.shapes)
        self._gesture = new_gesture("point")
        point = Points((at,))
        self._session.edit(tr("place point"), lambda document: edits.add_shape(document, point), self._gesture)
        self._session.select(None)

    def drag(self, at: Position) -> None:
        """Put it where the pointer is."""
        index, point = self._index, Points((at,))
        if index is not None:
            self._session.edit(
                tr("place point"), lambda document: edits.replace_shape(document, index, point), self._gesture
            )

    def release(self) -> None:
        """Leave it there."""
        self._index = None
        self._session.seal()

    def cancel(self) -> None:
        """Take it back."""
        index = self._index
        if index is not None:
            self._session.edit(tr("place point"), lambda document: edits.delete_shape(document, index), self._gesture)
        self.release()
