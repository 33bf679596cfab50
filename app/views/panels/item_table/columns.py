"""A column of a table: the text of each row and its sort key."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from app.model.text.language import written

Row = TypeVar("Row")

NONE = "–"
"""Text of a cell without a number."""


@dataclass(frozen=True)
class Column(Generic[Row]):
    """One column: heading (with ``{unit}`` for the unit of lengths), tooltip, text and sort key of a row.

    `sample` is the widest usual text; `numeric` columns are aligned to the right; `power` is 1 for
    lengths, 2 for areas.
    """

    name: str
    title: str
    tip: str
    text: Callable[[Row], str]
    value: Callable[[Row], float | str]
    sample: str
    numeric: bool = True
    power: int = 0

    def shown(self, row: Row, factor: float) -> str:
        """Its text for a row; lengths and areas are multiplied by a factor of lengths."""
        text = self.text(row)
        if self.power == 0 or factor == 1.0 or text == NONE:
            return text
        return number_text(float(self.value(row)) * factor**self.power)


def place(columns: Sequence[Column[Any]], name: str) -> int:
    """Place of a column among all."""
    return next(index for index, column in enumerate(columns) if column.name == name)


def number_text(value: float) -> str:
    """A number with three significant digits, or all digits before the point."""
    return (
        written(f"{value:,.0f}")
        if value >= 1000
        else written(f"{value:.3g}")
        if value < 100
        else written(f"{value:.0f}")
    )
