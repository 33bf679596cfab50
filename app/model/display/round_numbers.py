"""Round numbers, 1, 2 and 5 times a power of ten, and numbers as text without an exponent after an “e”."""

from __future__ import annotations

import math

import numpy as np


def round_up(value: float) -> float:
    """The smallest round number that is not below a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next((factor * power for factor in (1.0, 2.0, 5.0) if factor * power >= value), 10.0 * power)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def power_text(exponent: int) -> str:
    """A power of ten as text."""
    return "1" if exponent == 0 else "10" if exponent == 1 else f"10{str(exponent).translate(_RAISED)}"


def scientific_text(value: float) -> str:
    """A very small or very large number as text, such as 3.1·10⁻⁴."""
    digits, _, exponent = f"{value:.1e}".partition("e")
    return f"{digits}·{power_text(int(exponent))}"


def short_text(value: float) -> str:
    """A number with three digits, written out, so that it can also be typed again."""
    return str(np.format_float_positional(float(f"{value:.3g}"), trim="-"))
