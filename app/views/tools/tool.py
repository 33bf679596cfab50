"""What a tool is: that by which the pointer edits the drawing."""

from __future__ import annotations

import itertools
from typing import Protocol

from PySide6.QtCore import Qt

from cpm_core.paths import Position

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

    def press(self, at: Position, reach: float) -> None:
        """The left button goes down; `reach` is how far off still counts [px]."""

    def drag(self, at: Position) -> None:
        """The pointer moves with the button down."""

    def release(self) -> None:
        """The button comes up."""

    def hover(self, at: Position) -> None:
        """The pointer moves with the button up."""

    def finish(self) -> None:
        """End what it is in the middle of."""

    def take_back(self) -> None:
        """Take back the last part of what it is in the middle of."""

    def cancel(self) -> None:
        """Give up the gesture, as if it had not been begun."""

    def cursor(self, at: Position, reach: float) -> Cursor:
        """Shape of the pointer over a position."""


class Grip(Tool, Protocol):
    """A tool that takes hold of handles whichever tool is in use."""

    def grips(self, at: Position, reach: float) -> bool:
        """Whether there is a handle to take hold of."""


class Momentary:
    """What all tools have in common whose gestures last as long as the button is down."""

    drafting = False
    advice = ""

    def hover(self, at: Position) -> None:
        """Nothing follows the pointer."""

    def finish(self) -> None:
        """Nothing is left to be ended."""

    def take_back(self) -> None:
        """Nothing is left to be taken back."""
