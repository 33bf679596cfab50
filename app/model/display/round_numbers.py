"""Round numbers: 1, 2 and 5 times a power of ten."""

from __future__ import annotations

import math


def round_up(value: float) -> float:
    """The smallest round number that is not below a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next((factor * power for factor in (1.0, 2.0, 5.0) if factor * power >= value), 10.0 * power)


def round_down(value: float) -> float:
    """The largest round number that is not above a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return next((factor * power for factor in (5.0, 2.0, 1.0) if factor * power <= value), power / 2.0)
