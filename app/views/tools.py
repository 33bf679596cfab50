"""The tools by which the pointer edits the drawing."""

from __future__ import annotations

import itertools
import math
from typing import Protocol

from PySide6.QtCore import Qt

from app.model import edits
from app.model.hit_testing import hit
from app.model.paths import Position
from app.model.shapes import SMALLEST_RADIUS, Circle, Path, Points, Shape, describe
from app.session.session import Session

Cursor = Qt.CursorShape

_gestures = itertools.count()


class Tool(Protocol):
    """What a tool does with the pointer; positions are (row, col) in px of the image."""

    @property
    def name(self) -> str:
        """What it is called in code."""

    @property
    def drafting(self) -> bool:
        """Whether it is in the middle of something with the button up."""

    @property
    def advice(self) -> str:
        """One sentence on what to do with it, empty when that is plain."""

    def press(self, at: Position, reach: float) -> None:
        """The left button goes down; `reach` is how far off still counts [px]."""

    def drag(self, at: Position) -> None:
        """The pointer moves with the button down."""

    def release(self) -> None:
        """The button comes up."""

    def hover(self, at: Position) -> None:
        """The pointer moves with the button up."""

    def finish(self) -> None:
        """End what it is in the middle of."""

    def take_back(self) -> None:
        """Take back the last part of what it is in the middle of."""

    def cancel(self) -> None:
        """Give up the gesture, as if it had not been begun."""

    def cursor(self, at: Position, reach: float) -> Cursor:
        """Shape of the pointer over a position."""


class Grip(Tool, Protocol):
    """A tool that takes hold of handles whichever tool is in use."""

    def grips(self, at: Position, reach: float) -> bool:
        """Whether there is a handle to take hold of."""


class Momentary:
    """What all tools have in common whose gestures last as long as the button is down."""

    drafting = False
    advice = ""

    def hover(self, at: Position) -> None:
        """Nothing follows the pointer."""

    def finish(self) -> None:
        """Nothing is left to be ended."""

    def take_back(self) -> None:
        """Nothing is left to be taken back."""


class SelectTool(Momentary):
    """Selects, moves and, by the handles, resizes."""

    name = "select"

    def __init__(self, session: Session) -> None:
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
        self._gesture = f"drag {next(_gestures)}"
        self._session.select(self._index)

    def drag(self, at: Position) -> None:
        """Move the selected shape, or its rim or corner."""
        if self._shape is None:
            return
        by = (at[0] - self._anchor[0], at[1] - self._anchor[1])
        if self._part == "handle" and isinstance(self._shape, Circle):
            self._replace("resize circle", self._shape.resized_to(at))
        elif self._part == "handle" and isinstance(self._shape, Path):
            self._replace(f"reshape {describe(self._shape)}", self._shape.reshaped(self._anchor, at))
        else:
            self._replace(f"move {describe(self._shape)}", self._shape.moved(by))

    def release(self) -> None:
        """Leave the shape where it is."""
        self._shape = None
        self._session.seal()

    def cancel(self) -> None:
        """Put the shape back."""
        if self._shape is not None:
            self._replace("move", self._shape)
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
        self._gesture = f"circle {next(_gestures)}"

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


class PointTool(Momentary):
    """Places a point, which follows the pointer for as long as the button is down."""

    name = "points"

    def __init__(self, session: Session) -> None:
        self._session = session
        self._index: int | None = None
        self._gesture = ""

    def press(self, at: Position, reach: float) -> None:
        """Place a point."""
        self._index = len(self._session.document.shapes)
        self._gesture = f"point {next(_gestures)}"
        point = Points((at,))
        self._session.edit("place point", lambda document: edits.add_shape(document, point), self._gesture)
        self._session.select(None)

    def drag(self, at: Position) -> None:
        """Put it where the pointer is."""
        index, point = self._index, Points((at,))
        if index is not None:
            self._session.edit(
                "place point", lambda document: edits.replace_shape(document, index, point), self._gesture
            )

    def release(self) -> None:
        """Leave it there."""
        self._index = None
        self._session.seal()

    def cancel(self) -> None:
        """Take it back."""
        index = self._index
        if index is not None:
            self._session.edit("place point", lambda document: edits.delete_shape(document, index), self._gesture)
        self.release()

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A cross."""
        return Cursor.CrossCursor
