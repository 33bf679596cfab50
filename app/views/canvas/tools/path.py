"""The tools that draw a path, corner by corner or freehand: lines, outlines of areas, and barriers."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from PySide6.QtCore import Qt

from app.model.document import edits
from app.model.document.document import ImageReference
from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.model.volume.slices import Slice
from app.session.signals import EDITING
from app.views.canvas.tools.drawn import box_between
from app.views.canvas.tools.tool import Tool, ToolContext
from app.views.theme import theme
from cpm_core.numerics import Place, Position, polyline
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

_Flat = tuple[Position, ...]

_InVolume = Callable[[_Flat, Slice, ImageReference, bool], Shape]
"""Makes a shape of a volume of corners in a slice; the last argument is whether they are of a dragged rectangle."""


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
    in_volume : callable or None
        The same in a volume; None for a path in space.
    """

    name: str
    make: Callable[[tuple[Place, ...]], Shape]
    title: str
    tip: str
    color: str = theme.DRAWING
    closed: bool = True
    in_volume: _InVolume | None = None

    @property
    def least(self) -> int:
        """Fewest corners that make a shape."""
        return 3 if self.closed else 2

    def is_slip(self, path: tuple[Place, ...]) -> bool:
        """Whether a path is too small to be intended."""
        if len(path) < self.least:
            return True
        return polyline.area(path) < _SMALLEST if self.closed else polyline.length(path) < _SHORTEST


def _box_around(path: _Flat, here: Slice, volume: ImageReference) -> tuple[Place, Place]:
    (top, left), (bottom, right) = (tuple(map(end, zip(*path, strict=True))) for end in (min, max))
    return box_between((top, left), (bottom, right), here, volume)


def _grid_in(path: _Flat, here: Slice, volume: ImageReference, boxed: bool) -> Shape:
    return BoxGrid.between(*_box_around(path, here, volume), volume.spacing)


def _threshold_in(path: _Flat, here: Slice, volume: ImageReference, boxed: bool) -> Shape:
    return BoxThreshold(*_box_around(path, here, volume))


def _region_in(path: _Flat, here: Slice, volume: ImageReference, boxed: bool) -> Shape:
    if boxed:
        return BoxRegion(*_box_around(path, here, volume))
    return PrismRegion(path, here.axis, 0.0, volume.shape[here.axis] - 1.0)


def _wall_in(path: _Flat, here: Slice, volume: ImageReference, boxed: bool) -> Shape:
    return Wall(path, here.axis, 0.0, volume.shape[here.axis] - 1.0)


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
    in_volume=_grid_in,
)
THRESHOLD = PathKind(
    "threshold",
    Threshold,
    tr("threshold"),
    tr("Drag, or click corner by corner, around where to start on strong edges; < and > change how strong."),
    in_volume=_threshold_in,
)
REGION = PathKind(
    "region",
    Region,
    tr("region of interest"),
    tr("Drag, or click corner by corner, around what particles are to stay in."),
    theme.REGION,
    in_volume=_region_in,
)
BARRIER = PathKind(
    "barrier",
    Barrier,
    tr("barrier"),
    tr("Drag, or click corner by corner, where no particle is to cross."),
    theme.BARRIER,
    closed=False,
    in_volume=_wall_in,
)


class PathTool(Tool):
    """Draws a path: a drag draws it freehand and finishes it; clicks place corners until it is finished.

    In a slice a drag around an area draws a rectangle. The draft is not part of the document, which therefore changes
    only once.
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
        self._first = self._freehand = self._boxed = self._eight_directions = False
        self._begun: Slice | None = None
        self._reach = 0.0

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
        ends = tr("Enter or a double click ends it;")
        if self.kind.closed:
            ends = tr("Enter, a double click or the first corner ends it;")
        rest = tr("Shift keeps to eight directions; Backspace takes the last corner back; {key:escape} cancels.")
        return f"{ends} {with_keys(rest)}"

    def press(self, at: Place, reach: float) -> None:
        """Place a corner; a press on the last corner, or on the first one of a closed path, finishes it."""
        ends = [*self._corners[-1:], *(self._corners[:1] if self.kind.closed else [])]
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
        """Draw freehand, or a rectangle in a slice, after the pointer has left the place of the press."""
        if self._pressed is None:
            return
        self._freehand = self._freehand or math.dist(self._pressed, at) > self._reach
        if not self._freehand:
            return
        if self._first and self._begun is not None and self.kind.closed and self.kind.in_volume is not None:
            (top, left), (bottom, right) = self.flat(self._pressed), self.flat(at)
            corners = ((top, left), (top, right), (bottom, right), (bottom, left))
            self._corners, self._boxed = list(map(self.lifted, corners)), True
            self._changed()
        elif math.dist(self._corners[-1], at) >= max(_FINEST, 0.25 * self._reach):
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

    def set_modifiers(self, modifiers: Qt.KeyboardModifier) -> None:
        """With Shift, restrict the sides to eight directions."""
        self._eight_directions = bool(modifiers & Qt.KeyboardModifier.ShiftModifier)

    def finish(self) -> None:
        """Make a shape from the path."""
        if not self._corners:
            return
        kind, boxed, begun, volume = self.kind, self._boxed, self._begun, self.volume
        path = tuple(self._corners) if boxed else polyline.thinned(self._corners)
        self.cancel()
        flat = path
        if begun is not None and (kind.closed or kind.in_volume is not None):
            flat = tuple(map(begun.within, path))
        if kind.is_slip(flat):
            advice = tr("That is too small for a {shape}. {advice}").format(shape=kind.title, advice=kind.tip)
            self._session.say(advice, topic=EDITING)
            return
        if begun is not None and volume is not None and kind.in_volume is not None:
            shape = kind.in_volume(flat, begun, volume, boxed)
        else:
            shape = kind.make(path)
        self._session.edit(
            tr("draw {shape}").format(shape=kind.title), lambda document: edits.add_shape(document, shape)
        )
        self._session.select(len(self._session.document.shapes) - 1)

    def take_back(self) -> None:
        """Remove the last corner."""
        if self._corners:
            self._corners.pop()
            self._pressed = None
            self._changed()

    def cancel(self) -> None:
        """Discard the path."""
        self.used = self.used or bool(self._corners)
        self._corners = []
        self._pointer = self._pressed = None
        self._freehand = self._boxed = False
        self._changed()

    def _straight(self, at: Place) -> Place:
        """With Shift, the place nearest to the pointer in one of eight directions from the last corner."""
        if not (self._eight_directions and self._corners):
            return at
        (row, col), (high, wide) = self.flat(self._corners[-1]), self.sides
        down, right = self.flat(at)
        down, right = (down - row) * high, (right - col) * wide
        angle = math.radians(45.0 * round(math.degrees(math.atan2(down, right)) / 45.0))
        far = down * math.sin(angle) + right * math.cos(angle)
        return self.lifted((row + far * math.sin(angle) / high, col + far * math.cos(angle) / wide))

    def _changed(self) -> None:
        self._context.drawing.show_draft(self.corners, self.path, self.kind.color, self.kind.closed)
        self._context.advised()
