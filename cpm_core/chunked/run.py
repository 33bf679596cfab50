"""A run on an image larger than memory: survey it, run in each chunk, join what crosses seams, find objects."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

import numpy as np

from cpm_core.chunked import image_statistics
from cpm_core.chunked.chunk_objects import find_chunk_objects
from cpm_core.chunked.chunk_run import find_chunk_contours
from cpm_core.chunked.chunked_contours import (
    CONTOURS_KIND,
    JOINED_KIND,
    OBJECTS_KIND,
    ChunkedContours,
    ChunkedTask,
    chunk_file_name,
)
from cpm_core.chunked.grid import Chunk, ChunkGrid, build_grid, window_limits
from cpm_core.chunked.seams import join_pieces, split_by_core
from cpm_core.chunked.store import RunStore, pack_contours, unpack_contours
from cpm_core.contours.contour import Contour
from cpm_core.numerics.types import Integers
from cpm_core.objects.partition import ParentImage
from cpm_core.reconstruction.curve.hysteresis import least_contour_length

Compute = Callable[[Callable[[Any], Any], Sequence[Any], str], Iterable[tuple[int, Any]]]
"""Applies a function to jobs, in any order and on any workers, under a title; yields the index and result of each."""

STATISTICS_FILE = "whole.npz"
"""Name of the file with the statistics of the whole image."""


def run_chunks(task: ChunkedTask, compute: Compute, side: int) -> ChunkedContours:
    """Find all contours or objects; what the store holds of a run with the same settings is not found again."""
    task.store.open_run({**task.settings, "side": side, "shape": task.source.shape})
    grid, whole = survey_image(task, compute, side)
    map_chunks(compute, partial(find_contours_in_chunk, task, grid, whole), task.store, grid.chunks, CONTOURS_KIND)
    least = max(least_contour_length(whole.scaling.smoothing, task.parameters), task.parameters.min_length)
    found = ChunkedContours(task, grid, whole, _join_across_seams(task.store, grid, least))
    if whole.parent is None:
        return found
    map_chunks(compute, partial(find_objects_in_chunk, found, whole.parent), task.store, grid.chunks, OBJECTS_KIND)
    return ChunkedContours(task, grid, whole, _list_wide_objects(task.store, grid), OBJECTS_KIND)


def map_chunks(
    compute: Compute,
    process_chunk: Callable[[Chunk], None],
    store: RunStore,
    chunks: Iterable[Chunk],
    kind: str,
    title: str = "",
) -> None:
    """Process each of some chunks that has no file of a kind yet."""
    todo = [chunk for chunk in chunks if not store.has_file(chunk_file_name(kind, chunk.number))]
    for _ in compute(partial(_process_unless_done, process_chunk, store, kind), todo, title or kind):
        pass


def _process_unless_done(process_chunk: Callable[[Chunk], None], store: RunStore, kind: str, chunk: Chunk) -> None:
    """Process a chunk, unless a worker that died has done so."""
    if not store.has_file(chunk_file_name(kind, chunk.number)):
        process_chunk(chunk)


def survey_image(task: ChunkedTask, compute: Compute, side: int) -> tuple[ChunkGrid, image_statistics.ImageStatistics]:
    """Measure the statistics of the whole image, and divide the image into chunks."""
    source, parameters, shape = task.source, task.parameters, task.source.shape
    if task.store.has_file(STATISTICS_FILE):
        whole = image_statistics.ImageStatistics.from_arrays(task.store.load(STATISTICS_FILE), shape)
        return build_grid(shape, parameters, whole.scaling.smoothing, side), whole
    plain = ChunkGrid(shape, side, 0)
    gray = sort_results(compute(partial(image_statistics.measure_gray_levels, source), plain.chunks, "gray levels"))
    tone = image_statistics.find_scaling(source, plain, gray, parameters)
    frame = image_statistics.build_parent_image(source, plain, gray) if task.objects else None
    grid = build_grid(shape, parameters, tone.smoothing, side)
    work = partial(image_statistics.measure_edges, source, tone=tone, scales=parameters.scales)
    whole = image_statistics.combine_statistics(
        tone, sort_results(compute(work, grid.chunks, "edges")), parameters, frame
    )
    task.store.save(STATISTICS_FILE, **whole.arrays)
    return grid, whole


def sort_results(results: Iterable[tuple[int, Any]]) -> list[Any]:
    """Sort results by the order of their jobs."""
    return [result for _, result in sorted(results, key=lambda one: one[0])]


def find_contours_in_chunk(
    task: ChunkedTask, grid: ChunkGrid, statistics: image_statistics.ImageStatistics, chunk: Chunk
) -> None:
    """Find the contours of a chunk and store those that it keeps."""
    found, links = find_chunk_contours(task, statistics, chunk)
    own, pieces = split_by_core(found, chunk, grid.shape)
    middles = np.array([link.mean(axis=0) for link in links]).reshape(-1, 2)
    between = [Contour(links[n], False) for n in np.flatnonzero(grid.find_chunk_numbers(middles) == chunk.number)]
    arrays = pack_contours(own) | pack_contours(pieces, "piece") | pack_contours(between, "link")
    task.store.save(chunk_file_name(CONTOURS_KIND, chunk.number), **arrays)


def find_objects_in_chunk(found: ChunkedContours, parent: ParentImage, chunk: Chunk) -> None:
    """Find the objects between contours in a chunk and store them."""
    contours = find_chunk_objects(found, parent, chunk)
    found.task.store.save(chunk_file_name(OBJECTS_KIND, chunk.number), **pack_contours(contours))


def _join_across_seams(store: RunStore, grid: ChunkGrid, least: float) -> Integers:
    """Join what crosses seams to contours of at least a length, store them, and return the count of each chunk."""
    pieces: list[Contour] = []
    of_piece: list[int] = []
    counts = np.zeros(len(grid.chunks), np.int64)
    for chunk in range(len(counts)):
        known = store.load(chunk_file_name(CONTOURS_KIND, chunk))
        some = unpack_contours(known, "piece")
        pieces += some
        of_piece += [chunk] * len(some)
        counts[chunk] = len(known["own_counts"])
    joined = join_pieces(pieces, of_piece, least)
    boxes = np.array([one.box for one in joined]).reshape(-1, 2, 2)
    owners = grid.find_chunk_numbers(boxes.mean(axis=1))
    for chunk in np.unique(owners).tolist():
        own = [joined[n] for n in np.flatnonzero(owners == chunk)]
        store.save(chunk_file_name(JOINED_KIND, chunk), **pack_contours(own))
    store.save(f"{CONTOURS_KIND}.npz", boxes=boxes, chunks=owners)
    return tuple((counts + np.bincount(owners, minlength=len(counts))).tolist())


def _list_wide_objects(store: RunStore, grid: ChunkGrid) -> Integers:
    """List the contours of objects beyond the core of their chunk, and return the number of objects of each chunk."""
    counts, boxes, owners = [], [], []
    for chunk in grid.chunks:
        found = unpack_contours(store.load(chunk_file_name(OBJECTS_KIND, chunk.number)))
        low, high = window_limits(chunk.core)
        wide = [one.box for one in found if (one.box[0] < low).any() or (one.box[1] > high).any()]
        counts.append(max((one.group for one in found), default=0))
        boxes += wide
        owners += [chunk.number] * len(wide)
    store.save(f"{OBJECTS_KIND}.npz", boxes=np.array(boxes).reshape(-1, 2, 2), chunks=np.array(owners, np.int64))
    return tuple(counts)
