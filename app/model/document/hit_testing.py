"""Hit testing: which shape, and which part of it, lies under a position."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from cpm_core.numerics.types import Position
from cpm_core.shapes import Shape

Part = Literal["handle", "body"]


@dataclass(frozen=True, slots=True)
class Hit:
    """What was hit.

    Attributes
    ----------
    index : int
        Index of the shape in the document.
    part : {"handle", "body"}
        A handle resizes or reshapes, the body moves.
    """

    index: int
    part: Part


def hit(shapes: tuple[Shape, ...], position: Position, tolerance: float, selected: int | None = None) -> Hit | None:
    """The shape under a position; what is selected comes first, then what was drawn last.

    Parameters
    ----------
    shapes : tuple of Shape
        Shapes in the order drawn.
    position : tuple of float
        (row, col) in px of the image.
    tolerance : float
        How far off a line, handle or point still counts [px of the image].
    selected : int or None
        Shape whose handles are shown.
    """
    handles = shapes[selected].handles() if selected is not None and selected < len(shapes) else ()
    if selected is not None and any(math.dist(handle, position) <= tolerance for handle in handles):
        return Hit(selected, "handle")
    for index in _front_first(len(shapes), selected):
        if shapes[index].distance(position) <= tolerance:
            return Hit(index, "body")
    for index in _front_first(len(shapes), selected):
        if shapes[index].encloses(position):
            return Hit(index, "body")
    return None


def _front_first(count: int, selected: int | None) -> list[int]:
    order = list(reversed(range(count)))
    return sorted(order, key=lambda index: index != selected)
