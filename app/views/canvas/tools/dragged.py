"""What the tools have in common that draw a shape with a single drag."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar

from app.model.document import edits
from app.session.session import Session
from app.views.canvas.tools.tool import Momentary, new_gesture
from cpm_core.numerics.types import Position
from cpm_core.shapes import SMALLEST_RADIUS, Shape


class Dragged(Momentary):
    """Draws a shape between the place where the button goes down and the pointer.

    Parameters
    ----------
    session : Session
        Whose document gets the shape.
    """

    name: ClassVar[str]
    activity: ClassVar[str]
    """What is done, as it stands after "Undo"."""
    slip: ClassVar[str]
    """What is said when the pointer has not been moved."""

    def __init__(self, session: Session) -> None:
        super().__init__()
        self._session = session
        self._begin: Position | None = None
        self._index = 0
        self._gesture = ""

    @abstractmethod
    def shape(self, begin: Position, at: Position) -> Shape:
        """The shape between two places."""

    def press(self, at: Position, reach: float) -> None:
        """Begin a shape."""
        self._begin = at
        self._index = len(self._session.document.shapes)
        self._gesture = new_gesture(self.name)

    def drag(self, at: Position) -> None:
        """Lead it to the pointer."""
        if self._begin is not None and (self._drawn or math.dist(self._begin, at) >= SMALLEST_RADIUS):
            shape, index = self.shape(self._begin, at), self._index
            if self._drawn:
                self._session.edit(
                    self.activity, lambda document: edits.replace_shape(document, index, shape), self._gesture
                )
            else:
                self._session.edit(self.activity, lambda document: edits.add_shape(document, shape), self._gesture)
            self._session.select(index)

    def release(self) -> None:
        """Keep it."""
        if self._begin is not None and not self._drawn:
            self._session.say(self.slip)
        self.used = True
        self._begin = None
        self._session.seal()

    def cancel(self) -> None:
        """Take it back."""
        if self._begin is not None and self._drawn:
            index = self._index
            self._session.edit(self.activity, lambda document: edits.delete_shape(document, index), self._gesture)
        self._begin = None
        self._session.seal()

    @property
    def _drawn(self) -> bool:
        return len(self._session.document.shapes) > self._index
