"""Options of layers: declared once, shown in the panel and stored in a session file in the same way for all layers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

Value = str | float | bool


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several alternatives.

    Attributes
    ----------
    name, title, tip : str
        Name in a session file, name in the panel, and what it does in one sentence.
    ways : mapping
        Names and titles of the alternatives.
    first : str
        The default.
    """

    name: str
    title: str
    ways: Mapping[str, str]
    first: str
    tip: str

    def taken(self, value: object) -> Value | None:
        """The value to store, None when it is not one of the alternatives."""
        return value if isinstance(value, str) and value in self.ways else None


@dataclass(frozen=True, slots=True)
class Amount:
    """A number between `low` and `high` in increments of `step`, by default `first`; the rest is as in `Choice`."""

    name: str
    title: str
    low: float
    high: float
    step: float
    first: float
    tip: str

    def taken(self, value: object) -> Value | None:
        """The value to store, None when it is not a number within the bounds."""
        number = isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
        return float(value) if number and self.low <= value <= self.high else None  # type: ignore[operator,arg-type]


@dataclass(frozen=True, slots=True)
class Switch:
    """Something that is on or off, by default `first`; the rest is as in `Choice`."""

    name: str
    title: str
    first: bool
    tip: str

    def taken(self, value: object) -> Value | None:
        """The value to store, None when it is not a truth value."""
        return value if isinstance(value, bool) else None


Option = Choice | Amount | Switch
