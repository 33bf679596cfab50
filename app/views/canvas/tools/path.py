"""The tools that draw a path, corner by corner or freehand: lines, outlines of areas, and barriers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import Qt

from app.model.document import edits
from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.model.volume.slices import Slice
from app.session.signals import EDITING
from app.views.canvas.tools.drawn import box_between
from app.views.canvas.tools.tool import Tool, ToolContext
from app.views.theme import theme
from cpm_core.numerics import polyline
from cpm_core.numerics.types import Place, Position
from cpm_core.shapes import (
    Barrier,
    BoxGrid,
    BoxRegion,
    BoxThreshold,
    Grid,
    Polygon,
    PrismRegion,
    Region,
    Shape,
    Stroke,
    Threshold,
    Wall,
)

_FINEST = 1.0
"""Least distance between two corners of a freehand path [px]."""

_SHORTEST, _SMALLEST = 1.0, 4.0
"""Length [px] and area [px²] below which a path is taken for an accident."""


@dataclass(frozen=True, slots=True)
class PathKind:
    """What a path becomes.

    Attributes
    ----------
    name, tip : str
        Name of the tool, and how to use it.
    make : callable
        Corners to shape.
    title : str
        The shape in words.
    color : str
        Color of the draft.
    closed : bool
        Whether the last corner is joined to the first.
    extruded : callable or None
        In a volume: corners in a slice, its axis, and the first and last slice, to shape; None for a path in space.
    boxed : callable or None
        In a volume: two corners of a box to shape, for a drag; None where a drag draws freehand there too.
    filling : callable or None
        In a volume: two corners of a box and the sides of a voxel to shape, for the box around whatever is drawn.
    """

    name: str
    make: Callable[[tuple[Place, ...]], Shape]
    title: str
    tip: str
    color: str = theme.DRAWING
    closed: bool = True
    extruded: Callable[[tuple[Position, ...], int, float, float], Shape] | None = None
    boxed: Callable[[Place, Place], Shape] | None = None
    filling: Callable[[Place, Place, tuple[float, ...]], Shape] | None = None

    @property
    def least(self) -> int:
        """Fewest corners that make a shape."""
        return 3 if self.closed else 2

    def is_slip(self, path: tuple[Place, ...]) -> bool:
        """Whether a path is too small to be intended."""
        if len(path) < self.least:
            return True
        return polyline.area(path) < _SMALLEST if self.closed else polyline.length(path) < _SHORTEST


STROKE = PathKind(
    "stroke", Stroke, tr("stroke"), tr("Drag, or click corner by corner, where particles start."), closed=False
)
POLYGON = PathKind(
    "polygon", Polygon, tr("polygon"), tr("Click corner by corner, or drag, along a closed line to start from.")
)
GRID = PathKind(
    "grid_area",
    Grid,
    tr("grid"),
    tr("Drag, or click corner by corner, around an area to cover with an even grid; < and > change its spacing."),
    filling=BoxGrid.between,
)
THRESHOLD = PathKind(
    "threshold",
    Threshold,
    tr("threshold"),
    tr("Drag, or click corner by corner, around where to start on strong edges; < and > change how strong."),
    filling=lambda one, other, _: BoxThreshold(one, other),
)
REGION = PathKind(
    "region",
    Region,
    tr("region of interest"),
    tr("Drag, or click corner by corner, around what particles are to stay in."),
    theme.REGION,
    extruded=PrismRegion,
    boxed=BoxRegion,
)
BARRIER = PathKind(
    "barrier",
    Barrier,
    tr("barrier"),
    tr("Drag, or click corner by corner, where no particle is to cross."),
    theme.BARRIER,
    closed=False,
    extruded=Wall,
)


class PathTool(Tool):
    """Draws a path: a drag draws it freehand and finishes it; clicks place corners until it is finished.

    The draft is not part of the document, which therefore changes only once.
    """

    clicks = True
    by_keys = tr("Enter places a corner; Enter once more on the same place ends it.")

    def __init__(self, context: ToolContext, kind: PathKind) -> None:
        super().__init__(context)
        self.kind, self.name = kind, kind.name
        self._context = context
        self._corners: list[Place] = []
        self._pointer: Place | None = None
        self._pressed: Place | None = None
        self._first = False
        self._freehand = False
        self._begun: Slice | None = None
        self._boxed = False
        self._reach = 0.0
        self._bent = False

    @property
    def drafting(self) -> bool:
        """Whether a path has been begun and not finished."""
        return bool(self._corners)

    @property
    def corners(self) -> tuple[Place, ...]:
        """Corners of the path so far."""
        return tuple(self._corners)

    @property
    def path(self) -> tuple[Place, ...]:
        """The path as a click at the pointer would continue it."""
        return (*self._corners, *([self._pointer] if self._corners and self._pointer else []))

    @property
    def advice(self) -> str:
        """One sentence on what to do with this tool."""
        if not self._corners:
            return "" if self.used else self.kind.tip
        if self._freehand and self._first:
            return with_keys(tr("Let go to end it; {key:escape} cancels."))
        ends = (
            tr("Enter, a double click or the first corner ends it;")
            if self.kind.closed
            else (tr("Enter or a double click ends it;"))
        )
        bends = tr("Shift keeps to eight directions; Backspace takes the last corner back; {key:escape} cancels.")
        return f"{ends} {with_keys(bends)}"

    def press(self, at: Place, reach: float) -> None:
        """Place a corner; a press on the last corner, or on the first one of a closed path, finishes it."""
        ends = (self._corners[-1], *([self._corners[0]] if self.kind.closed else [])) if self._corners else ()
        if any(math.dist(at, end) <= reach for end in ends):
            if len(self._corners) >= self.kind.least:
                self.finish()
            return
        at = self._straight(at)
        self._first = not self._corners
        self._begun = self.here if self._first else self._begun
        self._pressed, self._reach, self._freehand = at, reach, False
        self._pointer = None
        self._corners.append(at)
        self._changed()

    def drag(self, at: Place) -> None:
        """Draw freehand after the pointer has left the place of the press."""
        if self._pressed is None:
            return
        self._freehand = self._freehand or math.dist(self._pressed, at) > self._reach
        if (
            self._freehand
            and self._first
            and self._begun is not None
            and (self.kind.boxed or self.kind.filling) is not None
        ):
            self._corners, self._boxed = self._rectangle(self._pressed, at), True
            self._changed()
        elif self._freehand and math.dist(self._corners[-1], at) >= max(_FINEST, 0.25 * self._reach):
            self._corners.append(at)
            self._changed()

    def release(self) -> None:
        """Finish a path that was drawn with one drag; any other waits for further corners."""
        whole = self._freehand and self._first
        self._pressed, self._freehand = None, False
        if whole:
            self.finish()

    def hover(self, at: Place) -> None:
        """Extend the path to the pointer."""
        if self._corners:
            self._pointer = self._straight(at)
            self._changed()

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """With Shift, restrict the sides to eight directions."""
        self._bent = bool(modifiers & Qt.KeyboardModifier.ShiftModifier)

    def finish(self) -> None:
        """Make a shape from the path."""
        if not self._corners:
            return
        kind, boxed, begun = self.kind, self._boxed, self._begun
        path = tuple(self._corners) if boxed else polyline.thinned(self._corners)
        self._forget()
        flat = begun if kind.closed or kind.extruded is not None else None
        if kind.is_slip(path if flat is None else tuple(map(flat.within, path))):
            self._session.say(
                tr("That is too small for a {shape}. {advice}").format(shape=kind.title, advice=kind.tip), topic=EDITING
            )
            return
        shape = kind.make(path) if begun is None else self._in_volume(path, begun, boxed)
        self._session.edit(
            tr("draw {shape}").format(shape=kind.title), lambda document: edits.add_shape(document, shape)
        )
        self._session.select(len(self._session.document.shapes) - 1)

    def _rectangle(self, one: Place, other: Place) -> list[Place]:
        (top, left), (bottom, right) = self.flat(one), self.flat(other)
        return [self.lifted(at) for at in ((top, left), (top, right), (bottom, right), (bottom, left))]

    def _in_volume(self, path: tuple[Place, ...], begun: Slice, boxed: bool) -> Shape:
        """A path in space, a box around a rectangle, or what is drawn in a slice through all slices."""
        kind, volume = self.kind, self.volume
        if kind.filling is not None and volume is not None:
            places = list(map(begun.within, path))
            low, high = (tuple(map(end, zip(*places, strict=True))) for end in (min, max))
            return kind.filling(*box_between(low, high, begun, volume), volume.spacing)
        if boxed and kind.boxed is not None and volume is not None:
            return kind.boxed(*box_between(begun.within(path[0]), begun.within(path[2]), begun, volume))
        if kind.extruded is None or volume is None:
            return kind.make(path)
        return kind.extruded(tuple(map(begun.within, path)), begun.axis, 0.0, volume.shape[begun.axis] - 1.0)

    def take_back(self) -> None:
        """Remove the last corner."""
        if self._corners:
            self._corners.pop()
            self._pressed = None
            self._changed()

    def cancel(self) -> None:
        """Discard the path."""
        self._forget()

    def _straight(self, at: Place) -> Place:
        """With Shift, the place nearest to the pointer in one of eight directions from the last corner."""
        if not (self._bent and self._corners):
            return at
        (row, col), (high, wide) = self.flat(self._corners[-1]), self.sides
        down, right = self.flat(at)
        down, right = (down - row) * high, (right - col) * wide
        angle = math.radians(45.0 * round(math.degrees(math.atan2(down, right)) / 45.0))
        far = down * math.sin(angle) + right * math.cos(angle)
        return self.lifted((row + far * math.sin(angle) / high, col + far * math.cos(angle) / wide))

    def _forget(self) -> None:
        self.used = self.used or bool(self._corners)
        self._corners = []
        self._pointer = self._pressed = None
        self._freehand = self._boxed = False
        self._changed()

    def _changed(self) -> None:
        self._context.drawing.show_draft(self.corners, self.path, self.kind.color, self.kind.closed)
        self._context.advised()
