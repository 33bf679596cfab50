"""The box of which a slice shows a rectangle that is drawn there."""

from __future__ import annotations

from app.model.document.document import ImageReference
from app.model.volume.slices import Slice
from cpm_core.numerics.types import Place, Position
from cpm_core.shapes.solids import SMALLEST


def box_between(one: Position, other: Position, here: Slice, volume: ImageReference) -> tuple[Place, Place]:
    """Two corners of a box: as deep as the shorter side of its rectangle, half on each side, within the volume."""
    sides = here.sides(volume.spacing)
    low, high = zip(*map(sorted, zip(one, other, strict=True)), strict=True)
    high = tuple(max(end, begin + SMALLEST) for begin, end in zip(low, high, strict=True))
    depth = min(side * (end - begin) for begin, end, side in zip(low, high, sides, strict=True))
    half = max(0.5 * depth / volume.spacing[here.axis], SMALLEST)
    first, last = list(here.lifted(low)), list(here.lifted(high))
    first[here.axis] = max(here.index - half, 0.0)
    last[here.axis] = min(here.index + half, volume.shape[here.axis] - 1.0)
    if last[here.axis] - first[here.axis] < SMALLEST:  # a volume of a single slice
        last[here.axis] = first[here.axis] + SMALLEST
    return tuple(first), tuple(last)
