"""The tools that draw a path, corner by corner or freehand: strokes, what is drawn around an area, and barriers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import Qt

from app.model.document import edits
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.layers.drawn.drawing import DrawingLayer
from app.views.theme import theme
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Position
from cpm_core.shapes import Barrier, Grid, Polygon, Region, Shape, Stroke, Threshold

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
    color : str
        Color of the path while it is drawn.
    closed : bool
        Whether the last corner is joined to the first.
    advice : str
        How to begin.
    """

    name: str
    make: Callable[[tuple[Position, ...]], Shape]
    title: str
    color: str
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
        return polyline.area(path) < _SMALLEST if self.closed else polyline.length(path) < _SHORTEST


STROKE = PathKind(
    "stroke",
    Stroke,
    tr("stroke"),
    theme.DRAWING,
    False,
    tr("Drag, or click corner by corner, where particles are to start."),
)
POLYGON = PathKind(
    "polygon",
    Polygon,
    tr("polygon"),
    theme.DRAWING,
    True,
    tr("Click corner by corner, or drag, along the line that particles are to start from."),
)
GRID = PathKind(
    "grid_area",
    Grid,
    tr("grid"),
    theme.DRAWING,
    True,
    tr("Drag, or click corner by corner, around what particles are to be spread over."),
)
THRESHOLD = PathKind(
    "threshold",
    Threshold,
    tr("threshold"),
    theme.DRAWING,
    True,
    tr("Drag, or click corner by corner, around what particles are to start in where edges are strong."),
)
REGION = PathKind(
    "region",
    Region,
    tr("region of interest"),
    theme.REGION,
    True,
    tr("Drag, or click corner by corner, around what particles are to stay in."),
)
BARRIER = PathKind(
    "barrier",
    Barrier,
    tr("barrier"),
    theme.BARRIER,
    False,
    tr("Drag, or click corner by corner, where nobody is to cross."),
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

    clicks = True
    sized = False
    by_keys = tr("Enter places a corner; Enter once more on the same place ends it.")

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
        self._bent = False
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
            return tr("Let go to end it; Esc gives up.")
        if self.kind.closed:
            return tr(
                "Enter, a double click or the first corner ends it; Shift keeps to eight directions; "
                "Backspace takes the last corner back; Esc gives up."
            )
        return tr(
            "Enter or a double click ends it; Shift keeps to eight directions; Backspace takes the last corner back; "
            "Esc gives up."
        )

    def press(self, at: Position, reach: float) -> None:
        """Place a corner; the first one closes a region, the last one once more ends a line."""
        ends = (self._corners[-1], *([self._corners[0]] if self.kind.closed else [])) if self._corners else ()
        if any(math.dist(at, end) <= reach for end in ends):
            if len(self._corners) >= self.kind.least:
                self.finish()
            return
        at = self._straight(at)
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
            self._pointer = self._straight(at)
            self._changed()

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """With Shift, sides keep to eight directions."""
        self._bent = bool(modifiers & Qt.KeyboardModifier.ShiftModifier)

    def resize(self, by: float) -> None:
        """It has no size."""

    def finish(self) -> None:
        """Make a shape of the path."""
        if not self._corners:
            return
        path, kind = polyline.thinned(self._corners), self.kind
        self._forget()
        if kind.is_slip(path):
            told = tr("That is too little for a {shape}. {advice}")
            self._session.say(told.format(shape=kind.title, advice=kind.advice))
            return
        shape = kind.make(path)
        self._session.edit(
            tr("draw {shape}").format(shape=kind.title), lambda document: edits.add_shape(document, shape)
        )
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

    def put_away(self) -> None:
        """What has been begun stays."""

    def cursor(self, at: Position, reach: float) -> Qt.CursorShape:
        """A cross."""
        return Qt.CursorShape.CrossCursor

    def _straight(self, at: Position) -> Position:
        """The place nearest to the pointer in one of eight directions from the last corner, where that is wanted."""
        if not (self._bent and self._corners):
            return at
        row, col = self._corners[-1]
        down, right = at[0] - row, at[1] - col
        angle = math.radians(45.0 * round(math.degrees(math.atan2(down, right)) / 45.0))
        far = down * math.sin(angle) + right * math.cos(angle)
        return (row + far * math.sin(angle), col + far * math.cos(angle))

    def _forget(self) -> None:
        self._advised = self._advised or bool(self._corners)
        self._corners = []
        self._pointer = self._pressed = None
        self._freehand = False
        self._changed()

    def _changed(self) -> None:
        self._drawing.show_draft(self.corners, self.path, self.kind.color, self.kind.closed)
        self._advised_to()
