"""The tools that work within a ring around the pointer: spray and eraser."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np

from app.model.document import edits
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.layers.drawn.drawing import DrawingLayer
from app.views.canvas.tools.tool import Momentary, new_gesture
from app.views.theme import theme
from cpm_core.numerics.types import Position
from cpm_core.shapes import Points, Shape

_SHARE, _LEAST, _MOST = 0.03, 1.0, 500.0
"""Radius at first, as a part of the image's longest side, and its bounds [px]."""

_FACTOR = 1.2
"""How much larger the ring gets at a time."""

_APART = 2.0
"""Least distance between two points of one gesture [px], which is that of particles on drawn lines."""

_DENSITY = 0.05
"""Points that are tried for each px² of the ring, and each radius that it is moved by."""

_MOST_POINTS = 20_000
"""Points of one gesture beyond which no more are added."""


class Ringed(Momentary):
    """Works within a ring that follows the pointer and is made smaller and larger.

    Parameters
    ----------
    session : Session
        Whose document it edits.
    drawing : DrawingLayer
        Shows the ring.
    """

    name: ClassVar[str]
    color: ClassVar[str]
    sized = True

    def __init__(self, session: Session, drawing: DrawingLayer) -> None:
        super().__init__()
        self._session = session
        self._drawing = drawing
        self._chosen: float | None = None
        self._at: Position | None = None
        self._last: Position | None = None
        self._gesture = ""
        self._before: tuple[Shape, ...] = ()

    @property
    def radius(self) -> float:
        """Radius of the ring [px of the image]."""
        if self._chosen is not None:
            return self._chosen
        image = self._session.document.image
        return max(_SHARE * max(image.shape), 4.0) if image is not None else 4.0

    def work(self, path: tuple[Position, ...], gesture: str) -> None:
        """Do what it does along a path."""
        raise NotImplementedError

    def press(self, at: Position, reach: float) -> None:
        """Begin."""
        self._gesture, self._last, self.used = new_gesture(self.name), at, True
        self._before = self._session.document.shapes
        self._session.select(None)
        self.hover(at)
        self.work((at,), self._gesture)

    def drag(self, at: Position) -> None:
        """Go on along the way of the pointer."""
        self.hover(at)
        if self._last is not None and at != self._last:
            path, self._last = (self._last, at), at
            self.work(path, self._gesture)

    def release(self) -> None:
        """End."""
        self._last = None
        self._session.seal()

    def cancel(self) -> None:
        """Take back what the gesture has done to the drawing."""
        if self._last is not None:
            shapes = self._before
            self._session.edit("", lambda document: edits.set_shapes(document, shapes), self._gesture)
        self.release()

    def hover(self, at: Position) -> None:
        """Lead the ring along."""
        self._at = at
        self._drawing.show_ring(at, self.radius, self.color)

    def resize(self, by: float) -> None:
        """Make the ring larger or smaller."""
        self._chosen = min(max(self.radius * _FACTOR**by, _LEAST), _MOST)
        if self._at is not None:
            self.hover(self._at)

    def put_away(self) -> None:
        """Hide the ring."""
        self._at = None
        self._drawing.show_ring(None, 0.0, self.color)


class SprayTool(Ringed):
    """Scatters points in the ring, for as long as the button is down and the pointer moves."""

    name = "spray"
    color = theme.DRAWING
    guidance = tr("Drag to spray points; < and > make the ring smaller and larger.")
    by_keys = tr("Enter begins to spray, arrow keys go on, Enter ends; < and > change the ring.")

    def __init__(self, session: Session, drawing: DrawingLayer) -> None:
        super().__init__(session, drawing)
        self._random = np.random.default_rng(0)
        self._index = 0
        self._taken: dict[tuple[int, int], Position] = {}

    def press(self, at: Position, reach: float) -> None:
        """Begin a new cloud of points."""
        self._index = len(self._session.document.shapes)
        self._taken = {}
        super().press(at, reach)

    def work(self, path: tuple[Position, ...], gesture: str) -> None:
        """Scatter points about the way that the ring has gone; none lands too near another."""
        far = math.dist(path[0], path[-1]) / self.radius if len(path) > 1 else 2.0
        many = self._random.poisson(_DENSITY * math.pi * self.radius**2 * far) + (len(path) == 1)
        share = self._random.random(many)[:, None]
        middle = np.array(path[0]) + share * np.subtract(path[-1], path[0])
        angle, off = 2.0 * math.pi * self._random.random(many), self.radius * np.sqrt(self._random.random(many))
        for row, col in (middle + off[:, None] * np.stack([np.sin(angle), np.cos(angle)], axis=1)).tolist():
            self._place((row, col))
        if not self._taken:
            return
        points, index = Points(tuple(self._taken.values())), self._index
        if len(self._session.document.shapes) > index:
            self._session.edit(
                tr("spray points"), lambda document: edits.replace_shape(document, index, points), gesture
            )
        else:
            self._session.edit(tr("spray points"), lambda document: edits.add_shape(document, points), gesture)

    def _place(self, at: Position) -> None:
        """Keep a point in the cell of a raster that is fine enough for one only; look at the cells around."""
        image = self._session.document.image
        if image is None or len(self._taken) >= _MOST_POINTS:
            return
        if not all(-0.5 <= number <= n - 0.5 for number, n in zip(at, image.shape, strict=True)):
            return
        row, col = (math.floor(number * math.sqrt(2.0) / _APART) for number in at)
        cells = ((row + down, col + right) for down in range(-2, 3) for right in range(-2, 3))
        if all(math.dist(at, self._taken[cell]) >= _APART for cell in cells if cell in self._taken):
            self._taken[row, col] = at


class EraserTool(Ringed):
    """Erases the points in its ring, the other shapes that it touches, and the particles of a run in it."""

    name = "eraser"
    color = theme.CHOSEN
    guidance = tr("Drag over points, shapes or particles to erase them; < and > make the ring smaller and larger.")
    by_keys = tr("Enter begins to erase, arrow keys go on, Enter ends; < and > change the ring.")

    def work(self, path: tuple[Position, ...], gesture: str) -> None:
        """Erase along the way of the ring."""
        left = self._session.live.erase(path, self.radius)
        self._session.edit(tr("erase"), lambda _: left, gesture)
