"""The tool that draws circles."""

from __future__ import annotations

import math

from app.model import edits
from app.session.session import Session
from app.views.tools.tool import Cursor, Momentary, new_gesture
from cpm_core.paths import Position
from cpm_core.shapes import SMALLEST_RADIUS, Circle


class CircleTool(Momentary):
    """Draws a circle from its centre."""

    name = "circle"

    def __init__(self, session: Session) -> None:
        self._session = session
        self._center: Position | None = None
        self._index = 0
        self._gesture = ""

    def press(self, at: Position, reach: float) -> None:
        """Begin a circle."""
        self._center = at
        self._index = len(self._session.document.shapes)
        self._gesture = new_gesture("circle")

    def drag(self, at: Position) -> None:
        """Lead the rim through the pointer."""
        if self._center is not None and (self._drawn or math.dist(self._center, at) >= SMALLEST_RADIUS):
            circle = Circle(self._center, max(math.dist(self._center, at), SMALLEST_RADIUS))
            index = self._index
            if self._drawn:
                self._session.edit(
                    "draw circle", lambda document: edits.replace_shape(document, index, circle), self._gesture
                )
            else:
                self._session.edit("draw circle", lambda document: edits.add_shape(document, circle), self._gesture)
            self._session.select(index)

    def release(self) -> None:
        """Keep the circle."""
        if self._center is not None and not self._drawn:
            self._session.say("Keep the button down and drag to draw a circle from its centre.")
        self._center = None
        self._session.seal()

    def cancel(self) -> None:
        """Take the circle back."""
        if self._center is not None and self._drawn:
            index = self._index
            self._session.edit("draw circle", lambda document: edits.delete_shape(document, index), self._gesture)
        self._center = None
        self._session.seal()

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A cross."""
        return Cursor.CrossCursor

    @property
    def _drawn(self) -> bool:
        return len(self._session.document.shapes) > self._index
