"""The objects of a volume larger than memory: its bodies, split where they touch, as those of a run in one piece."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from cpm_core.chunked.chunked_contours import OBJECTS_KIND, ChunkedTask, chunk_file_name
from cpm_core.chunked.grid import Chunk
from cpm_core.chunked.run import Compute, map_chunks
from cpm_core.chunked.volume_run import VOLUME_CHUNK_SIDE, run_particles
from cpm_core.chunked.volume_surface import ChunkedBodies, assemble_bodies, compute_heights, find_necks
from cpm_core.image.image import Image
from cpm_core.image.region import Region
from cpm_core.image.surface import Surface
from cpm_core.numerics.grids import Window, expand_window, first_pixel
from cpm_core.numerics.types import Index, JsonDict
from cpm_core.objects.all_bodies import find_bodies_everywhere
from cpm_core.objects.selection import Selection
from cpm_core.objects.volume_partition import VolumePartition

_BODY_MARGIN = 4
"""Voxels around a body that its objects and their confidence depend on."""

_TABLE_COLUMNS = ("volume", "area", "center", "confidence")
"""Columns of a table of objects besides their numbers."""

_OBJECT_TYPE = np.dtype(
    [
        ("body", np.int64),
        ("is_part", bool),
        ("volume", float),
        ("area", float),
        ("center", float, 3),
        ("confidence", float),
        ("first", np.int64, 3),
        ("shape", np.int64, 3),
    ]
)
"""What is stored of an object besides its voxels."""


def run_volume(task: ChunkedTask, compute: Compute, side: int = VOLUME_CHUNK_SIDE) -> ChunkedBodies:
    """Find all bodies, or objects; what the store holds of a run with the same settings is not found again."""
    task.store.open_run({**task.settings, "side": side, "shape": task.source.shape})
    heights = compute_heights(*run_particles(task, compute, side), compute)
    find_necks(heights, compute)
    bodies = assemble_bodies(heights, compute)
    return find_volume_objects(bodies, compute) if task.objects else bodies


def find_volume_objects(bodies: ChunkedBodies, compute: Compute) -> ChunkedBodies:
    """Find the objects of a volume: bodies split at necks, each with its confidence, the likeliest first.

    A body longer than what a chunk sees of the volume stays as it is, and its confidence is unknown.
    """
    store, grid, table = bodies.volume.task.store, bodies.grid, bodies.table
    map_chunks(compute, partial(_find_chunk_objects, bodies), store, grid.chunks, OBJECTS_KIND)
    found = [store.load(chunk_file_name(OBJECTS_KIND, chunk.number)) for chunk in grid.chunks]
    other = ~np.isin(table["label"], np.concatenate([one["body"] for one in found]))
    unchanged = {name: column[other] for name, column in table.items()}
    unchanged |= {"body": unchanged["label"], "is_part": np.zeros(other.sum(), bool)}
    unchanged["confidence"] = np.full(other.sum(), np.nan)
    rows = {
        name: np.concatenate([one[name] for one in (*found, unchanged)])
        for name in ("body", "is_part", *_TABLE_COLUMNS)
    }
    order = np.lexsort((-rows["volume"], -np.nan_to_num(rows["confidence"])))
    number = np.empty(len(order), np.int64)
    number[order] = np.arange(1, len(order) + 1)
    of_body = np.zeros(bodies.count + 1, np.int64)
    whole = ~rows["is_part"]
    of_body[rows["body"][whole]] = number[whole]
    ends = np.cumsum([len(one["body"]) for one in found])
    return replace(
        bodies,
        table={"label": np.arange(1, len(order) + 1)} | {name: rows[name][order] for name in _TABLE_COLUMNS},
        body_of_part=of_body[bodies.body_of_part],
        object_numbers=tuple(np.split(number, ends)[:-1]),
    )


def load_split_objects(bodies: ChunkedBodies, chunk: Chunk) -> Iterator[tuple[int, Region]]:
    """Load the objects of a chunk that bodies were split into, each with its number."""
    if not bodies.object_numbers:
        return
    known = bodies.volume.task.store.load(chunk_file_name(OBJECTS_KIND, chunk.number))
    is_part = known["is_part"]
    numbers, firsts, shapes = (
        column[is_part] for column in (bodies.object_numbers[chunk.number], known["first"], known["shape"])
    )
    masks = np.split(np.unpackbits(known["bits"]).view(bool), np.cumsum(shapes.prod(axis=1)))[:-1]
    for number, first, shape, mask in zip(numbers.tolist(), firsts.tolist(), shapes, masks, strict=True):
        yield number, Region.from_mask(mask.reshape(shape), first)


def _find_chunk_objects(bodies: ChunkedBodies, chunk: Chunk) -> None:
    """Find the objects of the bodies whose center is in a chunk, and store them."""
    volume, table, grid = bodies.volume, bodies.table, bodies.grid
    boxes = table["box"]
    short = (np.ptp(boxes, axis=1) <= grid.side + 2 * grid.overlap).all(axis=1)
    own = np.flatnonzero(short & (grid.find_chunk_numbers(table["center"]) == chunk.number))
    rows: list[JsonDict] = []
    if len(own):
        near = grid.find_chunks_in(_find_window(boxes[own], grid.shape))
        surfaces = _load_surfaces(bodies, near, table["label"][own])
        for body, box, surface in zip(table["label"][own].tolist(), boxes[own], surfaces, strict=True):
            window = _find_window(box[None], grid.shape)
            first = first_pixel(window)
            levels = volume.task.source.levels
            values = volume.task.source.read_values(window).astype(float)
            image = Image(values, levels.spacing, levels.unit, levels.name)
            part = VolumePartition(image, replace(surface, vertices=surface.vertices - first))
            rows += [_describe_object(one, body, first) for one in find_bodies_everywhere(part)]
    volume.task.store.save(chunk_file_name(OBJECTS_KIND, chunk.number), **_stack_rows(rows))


def _find_window(boxes: Any, shape: tuple[int, ...]) -> Window:
    """Find the voxels around boxes, shape (N, 2, 3)."""
    low, high = np.floor(boxes[:, 0].min(axis=0)), np.ceil(boxes[:, 1].max(axis=0)) + 1
    window = tuple(slice(max(int(a), 0), min(int(b), n)) for a, b, n in zip(low, high, shape, strict=True))
    return expand_window(window, _BODY_MARGIN, shape)


def _load_surfaces(bodies: ChunkedBodies, chunks: list[int], numbers: Index) -> list[Surface]:
    """Load the surfaces of bodies that lie in some chunks."""
    levels = bodies.volume.task.source.levels
    known = [bodies.load_triangles(number) for number in chunks]
    names, places, corners, body = (np.concatenate(parts) for parts in zip(*known, strict=True))
    order = np.argsort(names)
    by_body = np.argsort(body, kind="stable")
    begins, ends = (np.searchsorted(body[by_body], numbers, side) for side in ("left", "right"))
    found = []
    for begin, end in zip(begins.tolist(), ends.tolist(), strict=True):
        used, index = np.unique(corners[by_body[begin:end]], return_inverse=True)
        vertices = places[order][np.searchsorted(names[order], used)].astype(float)
        found.append(Surface(vertices, index.reshape(-1, 3), levels.spacing, levels.unit))
    return found


def _describe_object(found: Selection, body: int, first: Index) -> JsonDict:
    """Describe an object of a body in a window that begins at a voxel."""
    surface, region = found.surface, found.region
    assert surface is not None
    return {
        "body": body,
        "is_part": region.surface is None,
        "volume": found.size,
        "area": surface.area,
        "center": np.argwhere(region.mask).mean(axis=0) + region.origin + first,
        "confidence": found.confidence,
        "first": np.array(region.origin) + first,
        "shape": region.mask.shape,
        "mask": region.mask if region.surface is None else np.empty(0, bool),
    }


def _stack_rows(rows: list[JsonDict]) -> JsonDict:
    """Stack the descriptions of objects."""
    names = _OBJECT_TYPE.names or ()
    stacked = np.array([tuple(row[name] for name in names) for row in rows], _OBJECT_TYPE)
    masks = np.concatenate([np.empty(0, bool), *(row["mask"].ravel() for row in rows)])
    return {name: stacked[name] for name in names} | {"bits": np.packbits(masks)}
