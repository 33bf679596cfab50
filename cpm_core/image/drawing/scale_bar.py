"""The scale bar: a length that is easy to read, in a unit in which it has few digits."""

from __future__ import annotations

import math
from dataclasses import dataclass

METRIC = {"nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "m": 1.0}
"""Units in which a length is told, and what they are worth [m]."""

KNOWN = {**METRIC, "um": 1e-6, "cm": 1e-2}
"""Units that images have."""


@dataclass(frozen=True, slots=True)
class Bar:
    """A scale bar of round length, `pixels` of the image long."""

    pixels: float
    label: str


def longest_bar(most: float, spacing: float, unit: str | None, *, keep_unit: bool = False) -> Bar:
    """The longest scale bar of round length, 1, 2 or 5 times a power of ten, in a readable unit.

    `most` is its maximum length [px of the image], `spacing` the size of a pixel [unit], px without a unit. With
    `keep_unit` the length is told in this very unit.
    """
    size, name = (most * spacing, unit) if unit else (most, "px")
    if not keep_unit:
        size, name = _readable(size, name)
    length = round_down(size)
    return Bar(most * (length / size), f"{length:g} {name}" if length < 1e6 else f"{length:,.0f} {name}")


def round_down(value: float) -> float:
    """The largest round number, 1, 2 or 5 times a power of ten, that is not above a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next((factor * power for factor in (5.0, 2.0, 1.0) if factor * power <= value), power / 2.0)


def _readable(size: float, unit: str) -> tuple[float, str]:
    """The size in the metric unit in which it has one to three digits; unchanged in any other unit."""
    if unit not in KNOWN:
        return size, unit
    meters = size * KNOWN[unit]
    fitting = [name for name, worth in METRIC.items() if meters >= 0.999999 * worth]
    name = fitting[-1] if fitting else "nm"
    return meters / METRIC[name], name
