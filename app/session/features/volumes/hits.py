"""The shape under a place of the canvas, in an image or in a slice of a volume."""

from __future__ import annotations

from app.model.document.hit_testing import Hit, hit
from app.session.scene import Scene
from cpm_core.numerics.types import Place
from cpm_core.shapes.sections import section


def hit_in(scene: Scene, place: Place, tolerance: float) -> Hit | None:
    """The shape of a scene under a place; of a volume only what the current slice shows can be hit."""
    shapes, selected = scene.document.shapes, scene.selected
    if scene.slices is None:
        return hit(shapes, place, tolerance, selected)
    here = scene.slices.current
    cuts = [(index, section(shape, here.axis, here.index)) for index, shape in enumerate(shapes)]
    seen = [(index, shape) for index, shape in cuts if shape is not None]
    numbers = [index for index, _ in seen]
    chosen = numbers.index(selected) if selected in numbers else None
    found = hit(tuple(shape for _, shape in seen), here.within(place), tolerance, chosen)
    return None if found is None else Hit(numbers[found.index], found.part)
