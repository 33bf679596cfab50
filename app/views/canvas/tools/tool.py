"""What a tool is: that by which the pointer edits the drawing."""

from __future__ import annotations

import itertools
from typing import ClassVar, Protocol

from PySide6.QtCore import Qt

from app.model.text.language import tr
from cpm_core.numerics.types import Position

Cursor = Qt.CursorShape

_gestures = itertools.count()


def new_gesture(kind: str) -> str:
    """A name under which the edits of one gesture are undone together."""
    return f"{kind} {next(_gestures)}"


class Tool(Protocol):
    """What a tool does with the pointer; positions are (row, col) in px of the image."""

    @property
    def name(self) -> str:
        """What it is called in code."""

    @property
    def drafting(self) -> bool:
        """Whether it is in the middle of something with the button up."""

    @property
    def advice(self) -> str:
        """One sentence on what to do with it, empty when that is plain."""

    @property
    def by_keys(self) -> str:
        """One sentence on what Enter does with it at the cross-hair."""

    @property
    def clicks(self) -> bool:
        """Whether it works by clicks: Enter is a click then, else the button goes down with it and up with the next."""

    def press(self, at: Position, reach: float) -> None:
        """The left button goes down; `reach` is how far off still counts [px]."""

    def drag(self, at: Position) -> None:
        """The pointer moves with the button down."""

    def release(self) -> None:
        """The button comes up."""

    def hover(self, at: Position) -> None:
        """The pointer moves with the button up."""

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """These keys are held now, which may bend what is drawn to a rule."""

    @property
    def sized(self) -> bool:
        """Whether what it works with has a size."""

    def resize(self, by: float) -> None:
        """Make what it works with larger, for less than 0 smaller."""

    def finish(self) -> None:
        """End what it is in the middle of."""

    def take_back(self) -> None:
        """Take back the last part of what it is in the middle of."""

    def cancel(self) -> None:
        """Give up the gesture, as if it had not been begun."""

    def put_away(self) -> None:
        """The pointer has left, or another tool is used: nothing of it is to be seen."""

    def cursor(self, at: Position, reach: float) -> Cursor:
        """Shape of the pointer over a position."""


class Grip(Tool, Protocol):
    """A tool that takes hold of handles whichever tool is in use."""

    def grips(self, at: Position, reach: float) -> bool:
        """Whether there is a handle to take hold of."""


class Momentary:
    """What all tools have in common whose gestures last as long as the button is down."""

    drafting = False
    clicks = False
    sized = False
    by_keys = tr("Enter takes hold, arrow keys drag, Enter lets go.")
    guidance: ClassVar[str] = ""
    """One sentence on how to begin with it, said until it has been used."""

    def __init__(self) -> None:
        self.used = False

    @property
    def advice(self) -> str:
        """How to begin, until that is known."""
        return "" if self.used else self.guidance

    def hover(self, at: Position) -> None:
        """Nothing follows the pointer."""

    def bend(self, modifiers: Qt.KeyboardModifier) -> None:
        """There is no rule."""

    def resize(self, by: float) -> None:
        """It has no size."""

    def finish(self) -> None:
        """Nothing is left to be ended."""

    def take_back(self) -> None:
        """Nothing is left to be taken back."""

    def put_away(self) -> None:
        """Nothing of it is seen."""

    def cursor(self, at: Position, reach: float) -> Cursor:
        """A cross."""
        return Cursor.CrossCursor
