"""The tools that draw a path, corner by corner or freehand: strokes, regions of interest and barriers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import Qt

from app.model import edits
from app.session.session import Session
from app.views import theme
from app.views.layers.drawing import DrawingLayer
from cpm_core import paths
from cpm_core.paths import Position
from cpm_core.shapes import Barrier, Region, Shape, Stroke

_FINEST = 1.0
"""Least distance between two corners of a freehand path [px]."""

_SHORTEST, _SMALLEST = 1.0, 4.0
"""Length [px] and area [px²] under which a path is taken for a slip of the hand."""


@dataclass(frozen=True, slots=True)
class PathKind:
    """What a path becomes.

    Attributes
    ----------
    name : str
        Name of the tool.
    make : callable
        Corners to shape.
    title : str
        The shape in words.
    colour : str
        Colour of the path while it is drawn.
    closed : bool
        Whether the last corner is joined to the first.
    advice : str
        How to begin.
    """

    name: str
    make: Callable[[tuple[Position, ...]], Shape]
    title: str
    colour: str
    closed: bool
    advice: str

    @property
    def least(self) -> int:
        """Fewest corners that make a shape."""
        return 3 if self.closed else 2

    def is_slip(self, path: tuple[Position, ...]) -> bool:
        """Whether a path is too small to be meant."""
        if len(path) < self.least:
            return True
        return paths.area(path) < _SMALLEST if self.closed else paths.length(path) < _SHORTEST


STROKE = PathKind(
    "stroke", Stroke, "stroke", theme.DRAWING, False, "Drag, or click corner by corner, where particles are to start."
)
REGION = PathKind(
    "region",
    Region,
    "region of interest",
    theme.REGION,
    True,
    "Drag, or click corner by corner, around what particles are to stay in.",
)
BARRIER = PathKind(
    "barrier", Barrier, "barrier", theme.BARRIER, False, "Drag, or click corner by corner, where nobody is to cross."
)


class PathTool:
    """Draws a path: a drag draws it freehand and ends it; clicks place corners until it is ended.

    A path that is being drawn is no part of the document yet, which therefore changes only once.

    Parameters
    ----------
    session : Session
        Whose document gets the shape.
    kind : PathKind
        What is drawn.
    drawing : DrawingLayer
        Shows the path while it is drawn.
    advised : callable
        Told that `advice` may have changed.
    """

    def __init__(self, session: Session, kind: PathKind, drawing: DrawingLayer, advised: Callable[[], None]) -> None:
        self.kind = kind
        self.name = kind.name
        self._session = session
        self._drawing = drawing
        self._advised_to = advised
        self._corners: list[Position] = []
        self._pointer: Position | None = None
        self._pressed: Position | None = None
        self._first = False
        self._freehand = False
        self._reach = 0.0
        self._advised = False

    @property
    def drafting(self) -> bool:
        """Whether a path has been begun and not been ended."""
        return bool(self._corners)

    @property
    def corners(self) -> tuple[Position, ...]:
        """Corners of the path so far."""
        return tuple(self._corners)

    @property
    def path(self) -> tuple[Position, ...]:
        """The path as it would be if the pointer were clicked now."""
        return (*self._corners, *([self._pointer] if self._corners and self._pointer else []))

    @property
    def advice(self) -> str:
        """One sentence on what to do with this tool."""
        if not self._corners:
            return "" if self._advised else self.kind.advice
        if self._freehand and self._first:
            return "Let go to end it; Esc gives up."
        end = "Enter, a double click or the first corner" if self.kind.closed else "Enter or a double click"
        return f"{end} ends it; Backspace takes the last corner back; Esc gives up."

    def press(self, at: Position, reach: float) -> None:
        """Place a corner; the first one closes a region, the last one once more ends a line."""
        ends = (self._corners[-1], *([self._corners[0]] if self.kind.closed else [])) if self._corners else ()
        if any(math.dist(at, end) <= reach for end in ends):
            if len(self._corners) >= self.kind.least:
                self.finish()
            return
        self._first = not self._corners
        self._pressed, self._reach, self._freehand = at, reach, False
        self._pointer = None
        self._corners.append(at)
        self._changed()

    def drag(self, at: Position) -> None:
        """Draw freehand once the pointer has left the place where it was pressed."""
        if self._pressed is None:
            return
        self._freehand = self._freehand or math.dist(self._pressed, at) > self._reach
        if self._freehand and math.dist(self._corners[-1], at) >= max(_FINEST, 0.25 * self._reach):
            self._corners.append(at)
            self._changed()

    def release(self) -> None:
        """End a path that was drawn in one go; wait for further corners of any other."""
        whole = self._freehand and self._first
        self._pressed, self._freehand = None, False
        if whole:
            self.finish()

    def hover(self, at: Position) -> None:
        """Lead the path on to the pointer."""
        if self._corners:
            self._pointer = at
            self._changed()

    def finish(self) -> None:
        """Make a shape of the path."""
        if not self._corners:
            return
        path, kind = paths.thinned(self._corners), self.kind
        self._forget()
        if kind.is_slip(path):
            self._session.say(f"That is too little for a {kind.title}. {kind.advice}")
            return
        shape = kind.make(path)
        self._session.edit(f"draw {kind.title}", lambda document: edits.add_shape(document, shape))
        self._session.select(len(self._session.document.shapes) - 1)

    def take_back(self) -> None:
        """Take the last corner back."""
        if self._corners:
            self._corners.pop()
            self._pressed = None
            self._changed()

    def cancel(self) -> None:
        """Give the path up."""
        self._forget()

    def cursor(self, at: Position, reach: float) -> Qt.CursorShape:
        """A cross."""
        return Qt.CursorShape.CrossCursor

    def _forget(self) -> None:
        self._advised = self._advised or bool(self._corners)
        self._corners = []
        self._pointer = self._pressed = None
        self._freehand = False
        self._changed()

    def _changed(self) -> None:
        self._drawing.show_draft(self.corners, self.path, self.kind.colour, self.kind.closed)
        self._advised_to()
