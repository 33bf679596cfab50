"""The tools by which the pointer edits the drawing."""

from __future__ import annotations

import itertools
import math
from typing import Protocol

from PySide6.QtCore import Qt

from app.model import edits
from app.model.hit_testing import hit
from app.model.shapes import SMALLEST_RADIUS, Circle, Points, Position, Shape, describe
from app.session.session import Session

SPRAY_SPACING = 2.0
"""Distance between two points of a stroke [px]."""

Cursor = Qt.CursorShape

_gestures = itertools.count()


class Tool(Protocol):
    """What a tool does with the pointer; positions are (row, col) in px of the image."""

    @property
    def name(self) -> str:
        """What it is called in code."""

    def press(self, at: Position, reach: float) -> None:
        """The left button goes down; `reach` is how far off still counts [px]."""

    def drag(self, at: Position) -> None:
        """The pointer moves with the button down."""

    def release(self) -> None:
        """The button comes up."""

    def cancel(self) -> None:
        """Give up the gesture, as if it had not been begun."""

    def cursor(self, at: Position, reach: float) -> Cursor:
        """Shape of the pointer over a position."""


class SelectTool:
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
        """Move the selected shape, or its rim."""
        if self._shape is None:
            return
        by = (at[0] - self._anchor[0], at[1] - self._anchor[1])
        if self._part == "handle" and isinstance(self._shape, Circle):
            self._replace("resize circle", self._shape.resized_to(at))
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
        return Cursor.SizeAllCursor if found.part == "body" else _resize_cursor(self._session, found.index, at)

    def _replace(self, name: str, shape: Shape) -> None:
        index = self._index
        if index is not None and index < len(self._session.document.shapes):
            self._session.edit(name, lambda document: edits.replace_shape(document, index, shape), self._gesture)


class CircleTool:
    """Draws a circle from its centre; the handles of the selected one resize it as with the select tool."""

    name = "circle"

    def __init__(self, session: Session) -> None:
        self._session = session
        self._select = SelectTool(session)
        self._selecting = False
        self._center: Position | None = None
        self._index = 0
        self._gesture = ""

    def press(self, at: Position, reach: float) -> None:
        """Begin a circle, or take hold of a handle."""
        found = hit(self._session.document.shapes, at, reach, self._session.selected)
        self._selecting = found is not None and found.part == "handle"
        if self._selecting:
            self._select.press(at, reach)
            return
        self._center = at
        self._index = len(self._session.document.shapes)
        self._gesture = f"circle {next(_gestures)}"

    def drag(self, at: Position) -> None:
        """Lead the rim through the pointer."""
        if self._selecting:
            self._select.drag(at)
        elif self._center is not None and (self._drawn or math.dist(self._center, at) >= SMALLEST_RADIUS):
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
        if self._selecting:
            self._select.release()
        elif self._center is not None and not self._drawn:
            self._session.say("Keep the button down and drag to draw a circle from its centre.")
        self._selecting, self._center = False, None
        self._session.seal()

    def cancel(self) -> None:
        """Take the circle back."""
        if self._selecting:
            self._select.cancel()
        elif self._center is not None and self._drawn:
            index = self._index
            self._session.edit("draw circle", lambda document: edits.delete_shape(document, index), self._gesture)
        self._selecting, self._center = False, None
        self._session.seal()

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A cross, and arrows over a handle."""
        found = hit(self._session.document.shapes, at, reach, self._session.selected)
        if found is not None and found.part == "handle":
            return _resize_cursor(self._session, found.index, at)
        return Cursor.CrossCursor

    @property
    def _drawn(self) -> bool:
        return len(self._session.document.shapes) > self._index


class PointTool:
    """Places a point with a click and sprays a stroke of them with a drag."""

    name = "points"

    def __init__(self, session: Session) -> None:
        self._session = session
        self._stroke: list[Position] = []
        self._index = 0
        self._gesture = ""

    def press(self, at: Position, reach: float) -> None:
        """Place the first point."""
        self._stroke = [at]
        self._index = len(self._session.document.shapes)
        self._gesture = f"points {next(_gestures)}"
        points = Points((at,))
        self._session.edit("place point", lambda document: edits.add_shape(document, points), self._gesture)
        self._session.select(None)

    def drag(self, at: Position) -> None:
        """Place points evenly up to the pointer."""
        if not self._stroke:
            return
        placed = along(self._stroke[-1], at, SPRAY_SPACING)
        if placed:
            self._stroke.extend(placed)
            points, index = Points(tuple(self._stroke)), self._index
            self._session.edit(
                "spray points", lambda document: edits.replace_shape(document, index, points), self._gesture
            )

    def release(self) -> None:
        """Keep the points."""
        self._stroke = []
        self._session.seal()

    def cancel(self) -> None:
        """Take the points back."""
        if self._stroke:
            index = self._index
            self._session.edit("place point", lambda document: edits.delete_shape(document, index), self._gesture)
        self.release()

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A cross."""
        return Cursor.CrossCursor


def along(start: Position, end: Position, spacing: float) -> list[Position]:
    """Positions after `start` towards `end`, `spacing` apart."""
    length = math.dist(start, end)
    steps = int(length / spacing)
    unit = ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length else (0.0, 0.0)
    return [(start[0] + k * spacing * unit[0], start[1] + k * spacing * unit[1]) for k in range(1, steps + 1)]


def _resize_cursor(session: Session, index: int, at: Position) -> Cursor:
    shape = session.document.shapes[index]
    if isinstance(shape, Circle) and abs(at[0] - shape.center[0]) > abs(at[1] - shape.center[1]):
        return Cursor.SizeVerCursor
    return Cursor.SizeHorCursor
