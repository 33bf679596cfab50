"""Labels: names and colors of numbered objects."""

from __future__ import annotations

import re

from cpm_core.numerics.types import frozen
from cpm_core.parameters.formatting import quote_value


def check_color(what: str, color: str) -> None:
    """Raise a `ValueError` unless a color has the form "#rrggbb"; `what` names its owner."""
    if color and not re.fullmatch("#[0-9A-Fa-f]{6}", color):
        raise ValueError(
            f'The color of {what} is {quote_value(color)} but must be "#rrggbb", two hexadecimal digits each for red, '
            "green and blue, or empty."
        )


@frozen
class Label:
    """Name, color, ``"#rrggbb"``, and name of the class of the object with a number; each may be empty."""

    number: int
    name: str = ""
    color: str = ""
    category: str = ""

    def __post_init__(self) -> None:
        check_color("a label", self.color)
