"""The run in one chunk, in fields that are scaled as those of the whole image."""

from __future__ import annotations

from cpm_core.chunked.chunked_contours import ChunkedTask
from cpm_core.chunked.grid import Chunk
from cpm_core.chunked.image_statistics import ImageStatistics
from cpm_core.contours.contour import Contour
from cpm_core.field.scale_field import ScaleField
from cpm_core.image.image import Image
from cpm_core.model.starts import STRONG_EDGE_FRACTION, pixels_above, uniform_grid
from cpm_core.numerics.types import NO_POINTS, Array
from cpm_core.segmentation.engine import Engine
from cpm_core.segmentation.evolve import Evolution

CHUNKED_START_KINDS = ("grid", "gradient")
"""Kinds of automatic seeding that depend only on the surroundings of a point and on the strongest edge."""


_SEED_SPACING = 2
"""Distance of the seeds on strong edges along both axes [px].

Nearer ones would be deleted in the first steps, and take three times the memory and time.
"""


def find_chunk_contours(
    task: ChunkedTask, statistics: ImageStatistics, chunk: Chunk
) -> tuple[list[Contour], list[Array]]:
    """Find the contours and links of a run from everywhere in what a chunk sees, in px of the image."""
    values = statistics.scaling.scale_grays(task.source.read_grays(chunk.padded))
    own = statistics.scaling.adjust_parameters(task.parameters)
    if values.min() == values.max():
        return [], []
    corner = (chunk.padded[0].start, chunk.padded[1].start)
    image = Image(values, source=task.source.path.name)
    engine = Engine(
        image,
        own,
        measured=lambda field, scale, given: statistics.impose_on_field(field, scale, corner, given.edge_floor),
    )
    seeds = _place_chunk_seeds(engine.scale_field(own), task.kind)
    if not len(seeds):
        return [], []
    run = Evolution(engine, engine.start(seeds), own, task.max_steps)
    for _ in run:
        pass
    found = run.result
    contours = [
        Contour(one.points + corner, one.closed, one.strength, one.junctions, bridged=one.bridged)
        for one in found.contours
    ]
    return contours, [link + corner for link in found.links]


def _place_chunk_seeds(field: ScaleField, kind: str) -> Array:
    """Place the seeds of a chunk, shape (N, 2) [px of the chunk]; none where no edge is strong enough."""
    strength = field.edge_map
    if strength.max() < field.floor:
        return NO_POINTS
    if kind == "grid":
        return uniform_grid(field.shape)
    seeds = pixels_above(strength, STRONG_EDGE_FRACTION, field.strongest)
    return seeds[(seeds % _SEED_SPACING == 0.0).all(axis=1)]
