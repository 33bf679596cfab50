"""What the tools have in common that work within a ring around the pointer."""

from __future__ import annotations

from typing import ClassVar

from app.model.document import edits
from app.session.session import Session
from app.views.canvas.layers.drawn.drawing import DrawingLayer
from app.views.canvas.tools.tool import Momentary, new_gesture
from cpm_core.numerics.types import Position
from cpm_core.shapes import Shape

_SHARE, _LEAST, _MOST = 0.03, 1.0, 500.0
"""Radius at first, as a part of the image's longest side, and its bounds [px]."""

_FACTOR = 1.2
"""How much larger the ring gets at a time."""


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
    colour: ClassVar[str]
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
        self._drawing.show_ring(at, self.radius, self.colour)

    def resize(self, by: float) -> None:
        """Make the ring larger or smaller."""
        self._chosen = min(max(self.radius * _FACTOR**by, _LEAST), _MOST)
        if self._at is not None:
            self.hover(self._at)

    def put_away(self) -> None:
        """Hide the ring."""
        self._at = None
        self._drawing.show_ring(None, 0.0, self.colour)
