"""The tools that draw a path, corner by corner or freehand: lines, outlines of areas, and barriers."""

from __future__ import annotations

import math
from dataclasses import replace

from PySide6.QtCore import Qt

from cpm_app.model.document.document import ImageReference
from cpm_app.model.text.keys import insert_keys
from cpm_app.model.text.language import tr, translate_core_text
from cpm_app.model.volume.slices import Slice
from cpm_app.views.theme import theme
from cpm_app.views.tools.gesture_tools import box_between
from cpm_app.views.tools.tool import (
    MIN_DRAWN_AREA,
    Tool,
    draw_shape,
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
        self._is_first = self._boxed = False
        self._begun: Slice | None = None

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
            return "" if self.used and self._session.document.shapes else self.usage
        if self.is_dragged and self._is_first:
            return insert_keys(tr("Release to finish; {key:escape} cancels."))
        ends = tr("Enter or a double click ends it;")
        if self.closed:
            ends = tr("Enter, a double click or the first corner ends it;")
        rest = tr("Shift snaps to eight directions; Backspace removes the last corner; {key:escape} cancels.")
        return f"{ends} {insert_keys(rest)}"

    def on_press(self, at: Place) -> None:
        """Place a corner; a press on the last corner, or on the first one of a closed path, finishes it."""
        ends = [*self._corners[-1:], *(self._corners[:1] if self.closed else [])]
        if any(math.dist(at, end) <= self.reach for end in ends):
            self.stroke = []
            if len(self._corners) >= 2 + self.closed:
                self.finish()
            return
        self._is_first = not self._corners
        if self._is_first:  # what is stored knows no transposed slices
            self._begun = self.current_slice and replace(self.current_slice, transposed=False)
        self._corners.append(self._snap_direction(at))

    def on_drag(self, at: Place) -> None:
        """Draw freehand, or a rectangle around an area, after the pointer has left the place of the press."""
        if self.is_dragged and self._is_first and self.is_area:
            (top, left), (bottom, right) = self.position_in_slice(self.stroke[0]), self.position_in_slice(at)
            corners = ((top, left), (top, right), (bottom, right), (bottom, left))
            self._corners, self._boxed = list(map(self.place_in_image, corners)), True
        elif self.is_dragged and self.has_new_place:
            self._corners.append(at)

    def on_release(self) -> None:
        """Finish a path that was drawn with one drag; any other waits for further corners."""
        if self.is_dragged and self._is_first:
            self.finish()

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
            title = translate_core_text(self.shape_class.title)
            self.show_message(tr("That is too small for a {shape}. {advice}", shape=title, advice=self.usage))
            return
        draw_shape(self._session, shape)

    def remove_last_part(self) -> None:
        """Remove the last corner."""
        if self._corners:
            self._corners.pop()
            self._end_stroke()

    def cancel(self) -> None:
        """Discard the path."""
        self._corners, self._boxed = [], False
        super().cancel()

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

    def draw_marks(self) -> None:
        """Draw the path as far as the pointer."""
        rests = self._corners and self.pointer and not self.stroke
        ahead = [self._snap_direction(self.pointer)] if rests and self.pointer else []
        self._drawing.show_draft(self._corners, [*self._corners, *ahead], self.color, self.closed)


class StrokeTool(PathTool):
    """Draws a line that particles start from."""

    name = "stroke"
    menu_text = tr("S&troke")
    shortcut = "T"
    tip = tr("Drag, or click corner by corner, where particles start.")
    shape_class = Stroke
    closed = False
    is_spatial = True


class PolygonTool(PathTool):
    """Draws a closed line that particles start from."""

    name = "polygon"
    menu_text = tr("P&olygon")
    shortcut = "O"
    tip = tr("Click corner by corner, or drag, along a closed line to start from.")
    shape_class = Polygon
    is_spatial = True


class GridTool(PathTool):
    """Draws an area that is covered with an even grid of particles."""

    name = "grid_area"
    menu_text = tr("&Grid")
    shortcut = "G"
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
