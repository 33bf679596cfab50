"""The tool that sprays points."""

from __future__ import annotations

import math

import numpy as np

from app.model.document import edits
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.layers.drawn.drawing import DrawingLayer
from app.views.canvas.tools.ringed import Ringed
from app.views.theme import theme
from cpm_core.numerics.types import Position
from cpm_core.shapes import Points

_APART = 2.0
"""Least distance between two points of one gesture [px], which is that of particles on drawn lines."""

_DENSITY = 0.05
"""Points that are tried for each px² of the ring, and each radius that it is moved by."""

_MOST = 20_000
"""Points of one gesture beyond which no more are added."""


class SprayTool(Ringed):
    """Scatters points in the ring, for as long as the button is down and the pointer moves."""

    name = "spray"
    colour = theme.DRAWING
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
        if image is None or len(self._taken) >= _MOST:
            return
        if not all(-0.5 <= number <= n - 0.5 for number, n in zip(at, image.shape, strict=True)):
            return
        row, col = (math.floor(number * math.sqrt(2.0) / _APART) for number in at)
        cells = ((row + down, col + right) for down in range(-2, 3) for right in range(-2, 3))
        if all(math.dist(at, self._taken[cell]) >= _APART for cell in cells if cell in self._taken):
            self._taken[row, col] = at
