"""The tools that draw a shape with a single drag: circle and ellipse."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import ClassVar

from PySide6.QtCore import Qt

from app.model.document import edits
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.tools.tool import Momentary, new_gesture
from cpm_core.numerics.types import Position
from cpm_core.shapes import SMALLEST_RADIUS, Circle, Ellipse, Shape


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


class CircleTool(Dragged):
    """Draws a circle from its center."""

    name = "circle"
    activity = tr("draw circle")
    slip = tr("Keep the button down and drag to draw a circle from its center.")
    by_keys = tr("Enter begins at the center, arrow keys lead the rim, Enter ends.")

    def shape(self, begin: Position, at: Position) -> Circle:
        """The circle whose rim goes through the pointer."""
        return Circle(begin, max(math.dist(begin, at), SMALLEST_RADIUS))


class EllipseTool(Dragged):
    """Draws an ellipse from corner to corner of its box; with Ctrl from its center, with Shift as a circle."""

    name = "ellipse"
    activity = tr("draw ellipse")
    slip = tr("Keep the button down and drag to draw an ellipse.")
    guidance = tr("Drag a box around the ellipse; Shift makes it round, Ctrl draws it from its center.")
    by_keys = tr("Enter begins at a corner of its box, arrow keys lead the opposite one, Enter ends.")

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self._held = Qt.KeyboardModifier.NoModifier

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """Remember the keys."""
        self._held = modifiers

    def shape(self, begin: Position, at: Position) -> Ellipse:
        """The ellipse in the box, whose first radius lies along the row."""
        down, right = at[0] - begin[0], at[1] - begin[1]
        if self._held & Qt.KeyboardModifier.ShiftModifier:
            size = max(abs(down), abs(right))
            down, right = math.copysign(size, down), math.copysign(size, right)
        share, center = 1.0, begin
        if not self._held & Qt.KeyboardModifier.ControlModifier:
            share, center = 0.5, (begin[0] + 0.5 * down, begin[1] + 0.5 * right)
        return Ellipse(center, (max(share * abs(right), SMALLEST_RADIUS), max(share * abs(down), SMALLEST_RADIUS)))
