"""The run in one chunk, in fields that are measured as those of the whole image."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from cpm_core.chunked.grid import Chunk, Source
from cpm_core.chunked.survey import Whole
from cpm_core.contours.contour import Contour
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.model.starts import STRONG, above, uniform_grid
from cpm_core.numerics.types import Array
from cpm_core.parameters import Parameters
from cpm_core.segmentation.engine import Engine

KINDS = ("grid", "gradient")
"""Automatic seeding that looks at no more than the surroundings of a place and the strongest edge."""


class ChunkEngine(Engine):
    """The engine of a chunk, whose first pixel is `corner` of the image that `whole` is about."""

    def __init__(self, values: Image, parameters: Parameters, whole: Whole, corner: tuple[int, int]) -> None:
        self._whole, self._corner = whole, corner
        super().__init__(values, parameters)

    def _limit(self, regions: AnyRegions | None, free: Any = None) -> None:
        super()._limit(regions, free)
        plain = self._at

        @lru_cache(self.scales)
        def imposed(scale: int, parameters: Parameters) -> ScaleField:
            return self._whole.imposed(plain(scale, parameters), scale, self._corner, parameters.edge_floor)

        self._at = imposed


def contours_in(
    source: Source, chunk: Chunk, whole: Whole, parameters: Parameters, kind: str, max_steps: int | None
) -> tuple[Contour, ...]:
    """The contours that a run from everywhere finds in what a chunk sees, in px of the image."""
    values = whole.tone.apply(source.gray(chunk.padded))
    own = whole.tone.parameters(parameters)
    if values.min() == values.max():
        return ()
    corner = (chunk.padded[0].start, chunk.padded[1].start)
    engine = ChunkEngine(Image(values, source=source.path.name), own, whole, corner)
    seeds = _seeds(engine.scale_field(own), kind)
    if not len(seeds):
        return ()
    state = engine.start(seeds)
    while not state.stop_reason and state.step != max_steps:
        state = engine.step(state, own)
    found = engine.result(state, own).contours
    return tuple(
        Contour(one.points + corner, one.closed, one.strength, one.junctions, bridged=one.bridged) for one in found
    )


def _seeds(field: ScaleField, kind: str) -> Array:
    """Where particles start, shape (N, 2) [px of the chunk]; nowhere in a chunk without an edge that counts."""
    strength = field.edge_map
    if strength.max() < field.floor:
        return np.empty((0, 2))
    return uniform_grid(field.shape) if kind == "grid" else above(strength, STRONG, field.strongest)
