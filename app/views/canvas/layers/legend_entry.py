"""What a layer says of itself in the legend of the canvas."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Sign = Literal["line", "dashed", "dot", "check"]
"""How it is drawn: as a line, a dashed line, a disc, or not in a way of its own."""


@dataclass(frozen=True, slots=True)
class LegendEntry:
    """One kind of thing on the canvas.

    Attributes
    ----------
    count : int
        How many there are.
    text : str
        What they are, after their number.
    tip : str
        What that means, in one sentence.
    color : str
        Their color.
    sign : {"line", "dashed", "dot", "check"}
        How they are drawn.
    width : float
        Width of the line, or diameter of the disc [px of the screen].
    """

    count: int
    text: str
    tip: str
    color: str
    sign: Sign = "line"
    width: float = 2.0
