"""Lengths in readable units, and the scale bar."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.display.round_numbers import round_down

_METRIC = {"nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "m": 1.0}
_KNOWN = {**_METRIC, "um": 1e-6, "cm": 1e-2}
_PIXEL = "px"


@dataclass(frozen=True, slots=True)
class Bar:
    """A scale bar of round length, `pixels` of the image long."""

    pixels: float
    label: str


def bar(most: float, spacing: float, unit: str | None) -> Bar:
    """The longest scale bar of round length, 1, 2 or 5 times a power of ten, in a readable unit.

    `most` is its maximum length [px of the image], `spacing` the size of a pixel [unit], px without a unit.
    """
    size, name = (most * spacing, unit) if unit else (most, _PIXEL)
    size, name = _readable(size, name)
    length = round_down(size)
    return Bar(most * (length / size), f"{length:g} {name}" if length < 1e6 else f"{length:,.0f} {name}")


def length_text(pixels: float, spacing: float, unit: str | None) -> str:
    """A length in its unit, with four digits, or in whole pixels."""
    return f"{pixels * spacing:.4g} {unit}" if unit else f"{pixels:.0f} {_PIXEL}"


def _readable(size: float, unit: str) -> tuple[float, str]:
    """The size in the metric unit in which it has one to three digits; unchanged in any other unit."""
    if unit not in _KNOWN:
        return size, unit
    meters = size * _KNOWN[unit]
    fitting = [name for name, worth in _METRIC.items() if meters >= 0.999999 * worth]
    name = fitting[-1] if fitting else "nm"
    return meters / _METRIC[name], name
