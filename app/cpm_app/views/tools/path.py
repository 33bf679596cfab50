"""The tools that draw a path, corner by corner or freehand: lines, outlines of areas, and barriers."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt

from cpm_app.model.document import edits
from cpm_app.model.document.document import ImageReference
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import translate_core_text, tr
from cpm_app.model.volume.slices import Slice
from cpm_app.session.signals import EDITING_CATEGORY
from cpm_app.views.theme import theme
from cpm_app.views.tools.drawn import box_between
from cpm_app.views.tools.tool import AREA, CIRCLE, FREEHAND_SPACING, LIMIT, MIN_DRAWN_AREA, STROKE, Tool
from cpm_core.numerics import Place, polyline
from cpm_core.numerics.types import Line
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

_MIN_PATH_LENGTH = 1.0
"""Length below which an open path is taken for an accident [px]."""


class PathTool(Tool):
    """Draws a path: a drag draws it freehand and finishes it; clicks place corners until it is finished.

    In a slice, a drag around an area draws a rectangle. The draft is kept out of the document, so that the document
    changes only once.
    """

    clicks = True
    by_keys = tr("Enter places a corner; Enter once more on the same place ends it.")
    made: type[Stroke | Polygon | Grid | Threshold | Region | Barrier]
    """Class of the shape in an image."""
    color = theme.DRAWING
    closed = True
    """Whether the last corner is joined to the first."""
    spatial = False
    """Whether the path of a volume lies in space rather than in a slice."""

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        self._corners: list[Place] = []
        self._pointer: Place | None = None
        self._pressed: Place | None = None
        self._first = self._freehand = self._boxed = False
        self._begun: Slice | None = None
        self._reach = 0.0

    def solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build the shape in a volume from a path in a slice."""
        raise NotImplementedError

    @property
    def drafting(self) -> bool:
        """Whether a path has been begun and not finished."""
        return bool(self._corners)

    @property
    def advice(self) -> str:
        """Sentence on what to do next."""
        if not self._corners:
            return "" if self.used else self.tip
        if self._freehand and self._first:
            return insert_keys(tr("Release to finish; {key:escape} cancels."))
        ends = tr("Enter or a double click ends it;")
        if self.closed:
            ends = tr("Enter, a double click or the first corner ends it;")
        rest = tr("Shift snaps to eight directions; Backspace removes the last corner; {key:escape} cancels.")
        return f"{ends} {insert_keys(rest)}"

    def press(self, at: Place, reach: float) -> None:
        """Place a corner; a press on the last corner, or on the first one of a closed path, finishes it."""
        ends = [*self._corners[-1:], *(self._corners[:1] if self.closed else [])]
        if any(math.dist(at, end) <= reach for end in ends):
            if len(self._corners) >= 2 + self.closed:
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
        if self._first and self._begun is not None and self.closed and not self.spatial:
            (top, left), (bottom, right) = self.flat(self._pressed), self.flat(at)
            corners = ((top, left), (top, right), (bottom, right), (bottom, left))
            self._corners, self._boxed = list(map(self.lifted, corners)), True
            self._changed()
        elif math.dist(self._corners[-1], at) >= max(FREEHAND_SPACING, 0.25 * self._reach):
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

    def finish(self) -> None:
        """Turn the path into a shape."""
        if not self._corners:
            return
        begun, volume = self._begun, self.volume
        path = tuple(self._corners) if self._boxed else polyline.simplify_path(self._corners)
        flat = path if begun is None or (self.spatial and not self.closed) else tuple(map(begun.drop_axis, path))
        shape: Shape | None = None
        if polyline.enclosed_area(flat) >= MIN_DRAWN_AREA if self.closed else polyline.path_length(flat) >= _MIN_PATH_LENGTH:
            if begun is None or volume is None or self.spatial:
                shape = self.made(path)
            else:
                shape = self.solid(flat, begun, volume)
        self.cancel()
        if shape is None:
            advice = tr("That is too small for a {shape}. {advice}", shape=translate_core_text(self.made.title), advice=self.tip)
            self._session.show_message(advice, topic=EDITING_CATEGORY)
            return
        self._session.edit(
            tr("draw {shape}", shape=translate_core_text(shape.title)), lambda document: edits.add_shape(document, shape)
        )
        self._session.select_shape(len(self._session.document.shapes) - 1)

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
        """Snap a place, with Shift, to the nearest of eight directions from the last corner."""
        if not (self.modifiers & Qt.KeyboardModifier.ShiftModifier and self._corners):
            return at
        (row, col), (high, wide) = self.flat(self._corners[-1]), self.sides
        down, right = self.flat(at)
        down, right = (down - row) * high, (right - col) * wide
        angle = math.radians(45.0 * round(math.degrees(math.atan2(down, right)) / 45.0))
        far = down * math.sin(angle) + right * math.cos(angle)
        return self.lifted((row + far * math.sin(angle) / high, col + far * math.cos(angle) / wide))

    def _changed(self) -> None:
        ahead = [self._pointer] if self._corners and self._pointer else []
        self._drawing.show_draft(self._corners, [*self._corners, *ahead], self.color, self.closed)
        self._advised()


class StrokeTool(PathTool):
    """Draws a line that particles start from."""

    name = "stroke"
    text = tr("S&troke")
    shortcut = "T"
    group = STROKE
    tip = tr("Drag, or click corner by corner, where particles start.")
    made = Stroke
    closed = False
    spatial = True


class PolygonTool(PathTool):
    """Draws a closed line that particles start from."""

    name = "polygon"
    text = tr("P&olygon")
    shortcut = "O"
    group = CIRCLE
    tip = tr("Click corner by corner, or drag, along a closed line to start from.")
    made = Polygon
    spatial = True


class GridTool(PathTool):
    """Draws an area that is covered with an even grid of particles."""

    name = "grid_area"
    text = tr("&Grid")
    shortcut = "G"
    group = AREA
    tip = tr("Drag, or click corner by corner, around an area to cover with an even grid; [ and ] change its spacing.")
    made = Grid

    def solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build a grid in the box around the path."""
        return BoxGrid.from_corners(*_box_around(path, here, volume), volume.spacing)


class ThresholdTool(PathTool):
    """Draws an area in which particles start on strong edges."""

    name = "threshold"
    text = tr("T&hreshold")
    shortcut = "H"
    group = AREA
    tip = tr(
        "Drag, or click corner by corner, around an area in which to start on strong edges; [ and ] change how strong."
    )
    made = Threshold

    def solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build the box around the path."""
        return BoxThreshold(*_box_around(path, here, volume))


class RegionTool(PathTool):
    """Draws an area that particles stay in."""

    name = "region"
    text = tr("Region of &interest")
    shortcut = "I"
    group = LIMIT
    tip = tr("Drag, or click corner by corner, around the region that particles must stay in.")
    made = Region
    color = theme.REGION

    def solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build the box around a dragged rectangle, or the prism of another path through all slices."""
        if self._boxed:
            return BoxRegion(*_box_around(path, here, volume))
        return PrismRegion(path, here.axis, 0.0, volume.shape[here.axis] - 1.0)


class BarrierTool(PathTool):
    """Draws a line that no particle crosses."""

    name = "barrier"
    text = tr("&Barrier")
    shortcut = "B"
    group = LIMIT
    tip = tr("Drag, or click corner by corner, to draw a line that no particle crosses.")
    made = Barrier
    color = theme.BARRIER
    closed = False

    def solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build a wall across all slices."""
        return Wall(path, here.axis, 0.0, volume.shape[here.axis] - 1.0)


def _box_around(path: Line, here: Slice, volume: ImageReference) -> tuple[Place, Place]:
    (top, left), (bottom, right) = (tuple(map(end, zip(*path, strict=True))) for end in (min, max))
    return box_between((top, left), (bottom, right), here, volume)
