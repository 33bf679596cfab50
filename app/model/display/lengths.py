"""Lengths in the unit that makes their figures easy to read, and the bar that shows one of them."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.display.round_numbers import round_down

_METRIC = {"nm": 1e-9, "µm": 1e-6, "mm": 1e-3, "m": 1.0}
_KNOWN = {**_METRIC, "um": 1e-6, "cm": 1e-2}
_PIXEL = "px"


@dataclass(frozen=True, slots=True)
class Bar:
    """A bar of round length.

    Attributes
    ----------
    pixels : float
        Its length [px of the image].
    label : str
        Its length in words.
    """

    pixels: float
    label: str


def bar(most: float, spacing: float, unit: str | None) -> Bar:
    """The longest bar of round length, 1, 2 or 5 times a power of ten, in the unit in which it reads best.

    Parameters
    ----------
    most : float
        Most that it may measure [px of the image].
    spacing : float
        Size of a pixel [unit].
    unit : str or None
        Unit of the spacing; px where there is none.
    """
    size, name = (most * spacing, unit) if unit else (most, _PIXEL)
    size, name = _readable(size, name)
    length = round_down(size)
    return Bar(most * (length / size), f"{length:g} {name}" if length < 1e6 else f"{length:,.0f} {name}")


def length_text(pixels: float, spacing: float, unit: str | None) -> str:
    """A length in its unit, with as many figures as a tenth of a pixel is worth."""
    return f"{pixels * spacing:.4g} {unit}" if unit else f"{pixels:.0f} {_PIXEL}"


def _readable(size: float, unit: str) -> tuple[float, str]:
    """The size in the metric unit in which it has one to three figures; in its own when that is not a metric one."""
    if unit not in _KNOWN:
        return size, unit
    metres = size * _KNOWN[unit]
    fitting = [name for name, worth in _METRIC.items() if metres >= 0.999999 * worth]
    name = fitting[-1] if fitting else "nm"
    return metres / _METRIC[name], name
