"""The tools that work within a ring around the pointer: spray and eraser."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
import scipy

from cpm_app.model.text.language import tr
from cpm_app.session.features.object_brush import BRUSH_RADIUS_RANGE, default_brush_radius
from cpm_app.views.theme import theme
from cpm_app.views.tools.tool import ShapeTool
from cpm_core.numerics import Array, Place
from cpm_core.numerics.types import NO_POINTS
from cpm_core.shapes import Points

_RING_GROWTH = 1.2
"""Factor by which a key press enlarges the ring."""

_SPRAY_SPACING = 2.0
"""Minimum distance between two points of a gesture [px], as for particles on drawn lines."""

_SPRAY_DENSITY = 0.05
"""Candidate points per px² of the ring and per radius of movement."""

_MAX_SPRAY_POINTS = 20_000
"""Largest number of points of a gesture."""


class RingTool(ShapeTool):
    """Works within a ring that follows the pointer and can be resized."""

    color: str
    is_resizable = True

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        super().set_up()
        self._own_radius: float | None = None

    @property
    def radius(self) -> float:
        """Radius of the ring [px of the image]."""
        return self._own_radius or default_brush_radius(self._session.document.image)

    def apply_along(self, path: tuple[Place, ...]) -> None:
        """Apply the tool along a path of the ring; the path is a single place when the gesture begins."""
        raise NotImplementedError

    def on_press(self, at: Place) -> None:
        """Begin a gesture."""
        self._begin_gesture()
        self._session.select_shape(None)
        self.apply_along((at,))

    def on_drag(self, at: Place) -> None:
        """Continue along the path of the pointer."""
        if self.has_new_place:
            self.apply_along(tuple(self.stroke[-2:]))

    def draw_marks(self) -> None:
        """Draw the ring around the pointer."""
        self._drawing.show_ring(self.pointer, self.radius, self.color)

    def resize_by(self, by: float) -> None:
        """Make the ring larger or smaller."""
        self.set_radius(min(max(self.radius * _RING_GROWTH**by, BRUSH_RADIUS_RANGE[0]), BRUSH_RADIUS_RANGE[1]))
        self.update_marks()

    def set_radius(self, radius: float) -> None:
        """Set the radius of the ring [px of the image]."""
        self._own_radius = radius


class SprayTool(RingTool):
    """Scatters points in the ring while the button is down and the pointer moves."""

    name = "spray"
    menu_text = tr("Spra&y")
    shortcut = "Y"
    tip = tr("Drag to scatter points; [ and ] change the ring.")
    color = theme.DRAWING_COLOR
    guidance = tr("Drag to spray points; [ and ] make the ring smaller and larger.")
    keyboard_tip = tr("Enter begins to spray, arrow keys continue, Enter ends; [ and ] change the ring.")

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        super().set_up()
        self._points: Array = NO_POINTS
        """Points of the gesture so far [smallest side of a voxel], shape (N, 2)."""

    @cached_property
    def _random(self) -> np.random.Generator:
        return np.random.default_rng(0)  # created late, because it is slow to load

    def apply_along(self, path: tuple[Place, ...]) -> None:
        """Scatter points along the path of the ring, none too close to another."""
        image, sides = self._session.document.image, np.array(self.pixel_sides)
        if image is None:
            return
        if len(path) == 1:
            self._points = NO_POINTS
        begin, end = (np.array(self.position_in_slice(place)) * sides for place in (path[0], path[-1]))
        far = math.dist(begin, end) / self.radius if len(path) > 1 else 2.0
        many = self._random.poisson(_SPRAY_DENSITY * math.pi * self.radius**2 * far) + (len(path) == 1)
        share = self._random.random(many)[:, None]
        angle, off = 2.0 * math.pi * self._random.random(many), self.radius * np.sqrt(self._random.random(many))
        places = begin + share * (end - begin) + off[:, None] * np.stack([np.sin(angle), np.cos(angle)], axis=1)
        last = np.array(image.shape if self.current_slice is None else self.current_slice.drop_axis(image.shape)) - 0.5
        inside = ((places >= -0.5 * sides) & (places <= last * sides)).all(axis=1)
        points = np.concatenate([self._points, places[inside]])
        near = scipy.spatial.cKDTree(points).query_pairs(_SPRAY_SPACING, output_type="ndarray")
        self._points = np.delete(points, near.max(axis=1), axis=0)[:_MAX_SPRAY_POINTS]
        if len(self._points):
            placed = (self.place_in_image((row, col)) for row, col in (self._points / sides).tolist())
            self._put_shape(tr("spray points"), Points(tuple(placed)))


class EraserTool(RingTool):
    """Erases points and particles in its ring, and other shapes that it touches."""

    name = "eraser"
    menu_text = tr("&Eraser")
    shortcut = "E"
    tip = tr("Drag to erase points, shapes and particles; [ and ] change its ring.")
    color = theme.SELECTED_COLOR
    guidance = tr("Drag over points, shapes or particles to erase them; [ and ] make the ring smaller and larger.")
    keyboard_tip = tr("Enter begins to erase, arrow keys continue, Enter ends; [ and ] change the ring.")

    def set_up(self) -> None:
        """Initialize the state kept between events."""
        super().set_up()
        self._has_erased = False

    def apply_along(self, path: tuple[Place, ...]) -> None:
        """Erase along the path of the ring."""
        self._has_erased = self._session.erase(path, self.radius, self._gesture) or self._has_erased

    def on_release(self) -> None:
        """Keep the erased state."""
        self._has_erased = False
        super().on_release()

    def cancel(self) -> None:
        """Restore what the gesture has erased."""
        erased = self._has_erased
        self.release()
        if erased:
            self._session.undo()
