"""The shape under a place of the canvas, in an image or in a slice of a volume."""

from __future__ import annotations

from dataclasses import replace

from app.model.document.hit_testing import Hit, hit
from app.model.volume.slices import Slice
from app.session.features.volumes.sections import sections_of
from app.session.scene import Scene
from cpm_core.numerics.types import Place


def hit_in(scene: Scene, place: Place, tolerance: float, here: Slice | None = None) -> Hit | None:
    """The shape of a scene under a place; of a volume only what a slice shows can be hit.

    The slice is by default the one that is worked on.
    """
    shapes, selected = scene.document.shapes, scene.selected
    if scene.slices is None or scene.whole is None:
        return hit(shapes, place, tolerance, selected)
    here = scene.slices.current if here is None else here
    seen = list(sections_of(shapes, here, scene.whole))
    chosen: list[int | None] = [number for number, (index, _) in enumerate(seen) if index == selected]
    cuts = tuple(section for _, section in seen)
    found = None
    for number in chosen or [None]:  # a shape may have several sections, each with handles
        found = hit(cuts, here.within(place), tolerance, number)
        if found is not None and found.part == "handle":
            break
    if found is None:
        return None
    at = None if found.at is None else here.lifted(found.at)
    return replace(found, index=seen[found.index][0], at=at)
