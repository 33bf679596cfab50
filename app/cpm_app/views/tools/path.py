"""The tools that draw a path, corner by corner or freehand: lines, outlines of areas, and barriers."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt

from cpm_app.model.document import edits
from cpm_app.model.document.document import ImageReference
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.model.volume.slices import Slice
from cpm_app.session.session_messages import EDITING_CATEGORY
from cpm_app.views.theme import theme
from cpm_app.views.tools.gesture_tools import box_between
from cpm_app.views.tools.tool import (
    AREA_GROUP,
    CIRCLE_GROUP,
    FREEHAND_SPACING,
    LIMIT_GROUP,
    MIN_DRAWN_AREA,
    STROKE_GROUP,
    Tool,
)
from cpm_core.numerics import Place, polyline
from cpm_core.numerics.types import Line
from cpm_core.shapes import (
    Barrier,
    BoxGrid,
    BoxRegion,
    BoxThreshold,
    Grid,
    Polygon,
    PolygonRegion,
    PrismRegion,
    Shape,
    Stroke,
    Threshold,
    Wall,
)

_MIN_PATH_LENGTH = 1.0
"""Length below which an open path is taken for an accident [px]."""


class PathTool(Tool):
    """Draws a path: a drag draws it freehand and finishes it; clicks place corners until it is finished.

    A drag around an area draws a rectangle. The draft is kept out of the document, so that the document changes only
    once.
    """

    works_by_clicks = True
    keyboard_tip = tr("Enter places a corner; Enter once more on the same place ends it.")
    shape_class: type[Stroke | Polygon | Grid | Threshold | PolygonRegion | Barrier]
    """Class of the shape in an image."""
    color = theme.DRAWING_COLOR
    closed = True
    """Whether the last corner is joined to the first."""
    is_area = False
    """Whether the path encloses an area, around which a drag draws a rectangle."""
    is_spatial = False
    """Whether the path of a volume lies in space rather than in a slice."""

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        self._corners: list[Place] = []
        self._pointer: Place | None = None
        self._pressed: Place | None = None
        self._first = self._freehand = self._boxed = False
        self._begun: Slice | None = None
        self._reach = 0.0

    def build_solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build the shape in a volume from a path in a slice."""
        raise NotImplementedError

    @property
    def has_draft(self) -> bool:
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

    def on_press(self, at: Place, reach: float) -> None:
        """Place a corner; a press on the last corner, or on the first one of a closed path, finishes it."""
        ends = [*self._corners[-1:], *(self._corners[:1] if self.closed else [])]
        if any(math.dist(at, end) <= reach for end in ends):
            if len(self._corners) >= 2 + self.closed:
                self.finish()
            return
        at = self._snap_direction(at)
        self._first = not self._corners
        self._begun = self.current_slice if self._first else self._begun
        self._pressed, self._reach, self._freehand = at, reach, False
        self._pointer = None
        self._corners.append(at)
        self._show_draft()

    def on_drag(self, at: Place) -> None:
        """Draw freehand, or a rectangle around an area, after the pointer has left the place of the press."""
        if self._pressed is None:
            return
        self._freehand = self._freehand or math.dist(self._pressed, at) > self._reach
        if not self._freehand:
            return
        if self._first and self.is_area:
            (top, left), (bottom, right) = self.position_in_slice(self._pressed), self.position_in_slice(at)
            corners = ((top, left), (top, right), (bottom, right), (bottom, left))
            self._corners, self._boxed = list(map(self.place_in_image, corners)), True
            self._show_draft()
        elif math.dist(self._corners[-1], at) >= max(FREEHAND_SPACING, 0.25 * self._reach):
            self._corners.append(at)
            self._show_draft()

    def on_release(self) -> None:
        """Finish a path that was drawn with one drag; any other waits for further corners."""
        whole = self._freehand and self._first
        self._pressed, self._freehand = None, False
        if whole:
            self.finish()

    def on_hover(self, at: Place) -> None:
        """Extend the path to the pointer."""
        if self._corners:
            self._pointer = self._snap_direction(at)
            self._show_draft()

    def finish(self) -> None:
        """Turn the path into a shape."""
        if not self._corners:
            return
        begun, volume = self._begun, self.volume
        path = tuple(self._corners) if self._boxed else polyline.simplify_path(self._corners)
        flat = path if begun is None or (self.is_spatial and not self.closed) else tuple(map(begun.drop_axis, path))
        shape: Shape | None = None
        if (
            polyline.enclosed_area(flat) >= MIN_DRAWN_AREA
            if self.closed
            else polyline.path_length(flat) >= _MIN_PATH_LENGTH
        ):
            if begun is None or volume is None or self.is_spatial:
                shape = self.shape_class(path)
            else:
                shape = self.build_solid(flat, begun, volume)
        self.cancel()
        if shape is None:
            advice = tr(
                "That is too small for a {shape}. {advice}",
                shape=translate_core_text(self.shape_class.title),
                advice=self.tip,
            )
            self._session.messages.show(advice, category=EDITING_CATEGORY)
            return
        self._session.edit(
            tr("draw {shape}", shape=translate_core_text(shape.title)),
            lambda document: edits.add_shape(document, shape),
        )
        self._session.select_shape(len(self._session.document.shapes) - 1)

    def remove_last_part(self) -> None:
        """Remove the last corner."""
        if self._corners:
            self._corners.pop()
            self._pressed = None
            self._show_draft()

    def cancel(self) -> None:
        """Discard the path."""
        self.used = self.used or bool(self._corners)
        self._corners = []
        self._pointer = self._pressed = None
        self._freehand = self._boxed = False
        self._show_draft()

    def _snap_direction(self, at: Place) -> Place:
        """Snap a place, with Shift, to the nearest of eight directions from the last corner."""
        if not (self.modifiers & Qt.KeyboardModifier.ShiftModifier and self._corners):
            return at
        (row, col), (high, wide) = self.position_in_slice(self._corners[-1]), self.pixel_sides
        down, right = self.position_in_slice(at)
        down, right = (down - row) * high, (right - col) * wide
        angle = math.radians(45.0 * round(math.degrees(math.atan2(down, right)) / 45.0))
        far = down * math.sin(angle) + right * math.cos(angle)
        return self.place_in_image((row + far * math.sin(angle) / high, col + far * math.cos(angle) / wide))

    def _show_draft(self) -> None:
        ahead = [self._pointer] if self._corners and self._pointer else []
        self._drawing.show_draft(self._corners, [*self._corners, *ahead], self.color, self.closed)
        self._on_advice_changed()


class StrokeTool(PathTool):
    """Draws a line that particles start from."""

    name = "stroke"
    menu_text = tr("S&troke")
    shortcut = "T"
    group = STROKE_GROUP
    tip = tr("Drag, or click corner by corner, where particles start.")
    shape_class = Stroke
    closed = False
    is_spatial = True


class PolygonTool(PathTool):
    """Draws a closed line that particles start from."""

    name = "polygon"
    menu_text = tr("P&olygon")
    shortcut = "O"
    group = CIRCLE_GROUP
    tip = tr("Click corner by corner, or drag, along a closed line to start from.")
    shape_class = Polygon
    is_spatial = True


class GridTool(PathTool):
    """Draws an area that is covered with an even grid of particles."""

    name = "grid_area"
    menu_text = tr("&Grid")
    shortcut = "G"
    group = AREA_GROUP
    tip = tr(
        "Drag a rectangle, or click corner by corner, to cover an area with an even grid; [ and ] change its spacing."
    )
    shape_class = Grid
    is_area = True

    def build_solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build a grid in the box around the path."""
        return BoxGrid.from_corners(*_box_around(path, here, volume), volume.spacing)


class ThresholdTool(PathTool):
    """Draws an area in which particles start on strong edges."""

    name = "threshold"
    menu_text = tr("T&hreshold")
    shortcut = "H"
    group = AREA_GROUP
    tip = tr(
        "Drag a rectangle, or click corner by corner, to start on the strong edges in it; [ and ] change how strong."
    )
    shape_class = Threshold
    is_area = True

    def build_solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build the box around the path."""
        return BoxThreshold(*_box_around(path, here, volume))


class RegionTool(PathTool):
    """Draws an area that particles stay in."""

    name = "region"
    menu_text = tr("Region of &interest")
    shortcut = "I"
    group = LIMIT_GROUP
    tip = tr("Drag a rectangle, or click corner by corner, around the region that particles must stay in.")
    shape_class = PolygonRegion
    is_area = True
    color = theme.REGION_COLOR

    def build_solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build the box around a dragged rectangle, or the prism of another path through all slices."""
        if self._boxed:
            return BoxRegion(*_box_around(path, here, volume))
        return PrismRegion(path, here.axis, 0.0, volume.shape[here.axis] - 1.0)


class BarrierTool(PathTool):
    """Draws a line that no particle crosses."""

    name = "barrier"
    menu_text = tr("&Barrier")
    shortcut = "B"
    group = LIMIT_GROUP
    tip = tr("Drag, or click corner by corner, to draw a line that no particle crosses.")
    shape_class = Barrier
    color = theme.BARRIER_COLOR
    closed = False

    def build_solid(self, path: Line, here: Slice, volume: ImageReference) -> Shape:
        """Build a wall across all slices."""
        return Wall(path, here.axis, 0.0, volume.shape[here.axis] - 1.0)


def _box_around(path: Line, here: Slice, volume: ImageReference) -> tuple[Place, Place]:
    (top, left), (bottom, right) = (tuple(map(end, zip(*path, strict=True))) for end in (min, max))
    return box_between((top, left), (bottom, right), here, volume)
