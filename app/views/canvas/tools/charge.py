"""The tools that place charges."""

from __future__ import annotations

import math

from app.model.document import edits
from app.model.document.naming import describe
from app.model.text.language import tr
from app.session.session import Session
from app.views.canvas.tools.tool import Momentary, new_gesture
from cpm_core.numerics.types import Position
from cpm_core.shapes import Charge

STRENGTH = 2.0
"""Strength of a charge that is dropped: it draws particles off edges near it."""


class ChargeTool(Momentary):
    """Drops a charge, which follows the pointer for as long as the button is down, or takes hold of one that is there.

    Parameters
    ----------
    session : Session
        Whose document gets the charge.
    name : str
        Name of the tool.
    strength : float
        Strength of the charges, above zero for attracting ones.
    """

    by_keys = tr("Enter drops it or takes hold of one, arrow keys drag it, Enter lets go.")

    def __init__(self, session: Session, name: str, strength: float) -> None:
        super().__init__()
        self.name = name
        self._session = session
        self._strength = strength
        self._index: int | None = None
        self._before: Charge | None = None
        self._gesture = ""

    @property
    def advice(self) -> str:
        """What a charge does."""
        if self.used:
            return ""
        if self._strength > 0:
            return tr("Click to drop a charge that particles are drawn to; drag it while they run.")
        return tr("Click to drop a charge that drives particles away; drag it while they run.")

    def press(self, at: Position, reach: float) -> None:
        """Take hold of the charge under the pointer, or drop one."""
        self._gesture, self.used = new_gesture("charge"), True
        self._index, self._before = self._found(at, reach)
        if self._index is None:
            self._index, charge = len(self._session.document.shapes), Charge(at, self._strength)
            name = tr("drop {charge}").format(charge=describe(charge))
            self._session.edit(name, lambda document: edits.add_shape(document, charge), self._gesture)
        self._session.select(self._index)

    def drag(self, at: Position) -> None:
        """Put it where the pointer is."""
        charge = self._current()
        if charge is not None:
            self._put(Charge(at, charge.strength))

    def release(self) -> None:
        """Leave it there."""
        self._index = self._before = None
        self._session.seal()

    def cancel(self) -> None:
        """Put it back, or take it back."""
        index = self._index
        if self._before is not None:
            self._put(self._before)
        elif index is not None and self._current() is not None:
            self._session.edit("", lambda document: edits.delete_shape(document, index), self._gesture)
        self.release()

    def _put(self, charge: Charge) -> None:
        index = self._index
        verb = tr("drop {charge}") if self._before is None else tr("move {charge}")
        if index is not None:
            self._session.edit(
                verb.format(charge=describe(charge)),
                lambda document: edits.replace_shape(document, index, charge),
                self._gesture,
            )

    def _current(self) -> Charge | None:
        shapes = self._session.document.shapes
        shape = shapes[self._index] if self._index is not None and self._index < len(shapes) else None
        return shape if isinstance(shape, Charge) else None

    def _found(self, at: Position, reach: float) -> tuple[int | None, Charge | None]:
        near = [
            (math.dist(shape.position, at), -index, shape)
            for index, shape in enumerate(self._session.document.shapes)
            if isinstance(shape, Charge) and math.dist(shape.position, at) <= reach
        ]
        if not near:
            return None, None
        _, index, shape = min(near, key=lambda found: found[:2])
        return -index, shape
