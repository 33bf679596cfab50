"""What can be chosen about a layer: said once, shown in the panel and kept in a session file by all layers alike."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

Value = str | float | bool


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several ways.

    Attributes
    ----------
    name, title : str
        What it is called in a session file, and in the panel.
    ways : mapping
        Names and titles of the ways.
    first : str
        The one chosen at first.
    tip : str
        What it does, in a sentence.
    """

    name: str
    title: str
    ways: Mapping[str, str]
    first: str
    tip: str = ""

    def taken(self, value: object) -> Value | None:
        """The value as it is kept, None when it is not one of the ways."""
        return value if isinstance(value, str) and value in self.ways else None


@dataclass(frozen=True, slots=True)
class Amount:
    """A number within bounds.

    Attributes
    ----------
    name, title : str
        What it is called in a session file, and in the panel.
    low, high, step, first : float
        Bounds, increment, and the value at first.
    tip : str
        What it does, in a sentence.
    """

    name: str
    title: str
    low: float
    high: float
    step: float
    first: float
    tip: str = ""

    def taken(self, value: object) -> Value | None:
        """The value as it is kept, None when it is no number within the bounds."""
        number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        return float(value) if number and self.low <= value <= self.high else None  # type: ignore[operator,arg-type]


@dataclass(frozen=True, slots=True)
class Switch:
    """Something that is so or not.

    Attributes
    ----------
    name, title : str
        What it is called in a session file, and in the panel.
    first : bool
        How it is at first.
    tip : str
        What it does, in a sentence.
    """

    name: str
    title: str
    first: bool
    tip: str = ""

    def taken(self, value: object) -> Value | None:
        """The value as it is kept, None when it is no truth value."""
        return value if isinstance(value, bool) else None


Option = Choice | Amount | Switch
