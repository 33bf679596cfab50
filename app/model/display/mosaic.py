"""The plan of a mosaic: two parameters, some values of each, and the tiles of all combinations."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from app.model.display.round_numbers import short_text
from app.model.document.document import Document
from app.model.parameters.controls import Control, slider_range, value_of, with_value
from app.model.text.language import tr
from cpm_core.parameters import Parameters

FEWEST, MOST = 2, 6
"""Limits of the number of values of a parameter."""

COUNTS = (3, 4, 5)
"""Numbers of values that are proposed."""

FIRST_AXES = ("smoothing", "min_strength")
"""Parameters that are proposed: they decide which edges count."""

_SPREAD = 0.5
"""Fraction of the slider's range that the proposed values span."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One of the two parameters, with its values in ascending order."""

    control: Control
    values: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Tile:
    """One run of a mosaic: its place, its values of the two parameters, and all its parameters."""

    row: int
    col: int
    down: float
    across: float
    parameters: Parameters


@dataclass(frozen=True, slots=True)
class Plan:
    """A mosaic before it is run: the parameter of its rows, that of its columns, and its tiles row by row."""

    down: Axis
    across: Axis
    tiles: tuple[Tile, ...]

    def caption(self, tile: Tile) -> str:
        """The values of a tile as text."""
        down, across = self.down.control.symbol, self.across.control.symbol
        return f"{down} = {short_text(tile.down)}, {across} = {short_text(tile.across)}"


def plan(parameters: Parameters, down: Axis, across: Axis) -> Plan:
    """The plan of a mosaic whose tiles differ in two parameters.

    ValueError when both are the same parameter, or a value is out of its range.
    """
    if down.control.name == across.control.name:
        raise ValueError(tr("Both parameters are the same: choose two different ones."))
    tiles = [
        Tile(row, col, first, second, _with(parameters, down.control, first, across.control, second))
        for row, first in enumerate(down.values)
        for col, second in enumerate(across.values)
    ]
    return Plan(down, across, tuple(tiles))


def pick(document: Document, chosen: Plan, tile: Tile) -> Document:
    """The document with the two parameters of a tile; all others stay unchanged."""
    first, second = chosen.down.control, chosen.across.control
    return replace(document, parameters=_with(document.parameters, first, tile.down, second, tile.across))


def sensible_values(control: Control, parameters: Parameters, contrast: float, count: int) -> tuple[float, ...]:
    """Evenly spaced values around the current one, which is among them, over part of the slider's range.

    There are `count` values, fewer if there are not as many whole numbers; parameters in gray levels are scaled by the
    contrast of the image.
    """
    low, high = slider_range(control, contrast)
    step = 1.0 if control.whole else control.step
    present = value_of(parameters, control.name)
    middle = float(present) if isinstance(present, int | float) else 0.5 * (low + high)
    middle = min(max(middle, low), high)
    apart = max(step, _rounded(_SPREAD * (high - low) / (count - 1), step))
    before = min((count - 1) // 2, math.floor((middle - low) / apart + 1e-9))
    behind = min(count - 1 - before, math.floor((high - middle) / apart + 1e-9))
    before = min(count - 1 - behind, math.floor((middle - low) / apart + 1e-9))
    others = (_rounded(middle + index * apart, step) for index in range(-before, behind + 1) if index)
    within = {round(min(max(value, low), high), 9) for value in others}
    return tuple(sorted(within | {middle}))


def read_values(control: Control, text: str) -> tuple[float, ...]:
    """The numbers in a text, with spaces, semicolons or commas between them.

    ValueError when there are too few or too many, or one is not a number.
    """
    words = text.replace(";", " ").replace(",", " ").split()
    values = set()
    for word in words:
        try:
            value = float(word)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            message = tr("{title}: “{word}” is not a number; write numbers such as 0.4, 0.6, 0.8.")
            raise ValueError(message.format(title=control.title, word=word)) from None
        values.add(value)
    if not FEWEST <= len(values) <= MOST:
        message = tr("{title} has {count} different values but must have from {fewest} to {most}.")
        raise ValueError(message.format(title=control.title, count=len(values), fewest=FEWEST, most=MOST))
    return tuple(sorted(values))


def in_text(values: tuple[float, ...]) -> str:
    """Values as text that `read_values` reads, with three digits."""
    return ", ".join(map(short_text, values))


def _with(parameters: Parameters, first: Control, one: float, second: Control, other: float) -> Parameters:
    return with_value(with_value(parameters, first.name, one), second.name, other)


def _rounded(value: float, step: float) -> float:
    return round(value / step) * step
