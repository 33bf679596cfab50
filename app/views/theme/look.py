"""The look of lines and points on the canvas, as the user prefers it; all canvases share it.

Items read it when they paint, so that layers need not know of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Kind = Literal["contours", "shapes", "fixed"]
"""What a line belongs to; the width of fixed ones cannot be chosen."""


class Ink(str):
    """A color that the user can choose, by its name; as a text it is the default."""

    __slots__ = ("name",)

    def __new__(cls, name: str, default: str) -> Ink:
        """Make the color."""
        made = super().__new__(cls, default)
        made.name = name
        return made

    name: str


@dataclass(frozen=True, slots=True)
class Look:
    """Factors for the widths of lines and the size of points, and the colors that were chosen, by name."""

    contours: float = 1.0
    shapes: float = 1.0
    points: float = 1.0
    colors: Mapping[str, str] = field(default_factory=dict)

    def width(self, kind: Kind) -> float:
        """Factor for the width of lines."""
        return {"contours": self.contours, "shapes": self.shapes, "fixed": 1.0}[kind]

    def color(self, color: str) -> str:
        """The chosen color in place of a default one; any other color is unchanged."""
        return self.colors.get(color.name, str(color)) if isinstance(color, Ink) else color


_look = Look()


def look() -> Look:
    """The look in use."""
    return _look


def use_look(wanted: Look) -> None:
    """Set the look; canvases must be painted again."""
    global _look  # noqa: PLW0603  # one for all canvases, as the style sheet is one for all widgets
    _look = wanted
