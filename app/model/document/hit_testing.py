"""Hit testing: the shape, and its part, under a position."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal

from cpm_core.numerics.types import Position
from cpm_core.shapes import Shape

Part = Literal["handle", "body"]


@dataclass(frozen=True, slots=True)
class Hit:
    """Index of the shape that was hit, and its part: a handle, which is at a place, reshapes, the body moves."""

    index: int
    part: Part
    at: Position | None = field(default=None, compare=False)


def hit(shapes: tuple[Shape, ...], position: Position, tolerance: float, selected: int | None = None) -> Hit | None:
    """The shape under a position (row, col) [px of the image]; the selected one first, then the last drawn.

    `tolerance` is the distance up to which a line, handle or point is hit [px of the image]. Only the selected shape
    shows handles.
    """
    handles = shapes[selected].handles() if selected is not None and selected < len(shapes) else ()
    near = min(handles, key=lambda handle: math.dist(handle, position), default=None)
    if selected is not None and near is not None and math.dist(near, position) <= tolerance:
        return Hit(selected, "handle", near)
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
