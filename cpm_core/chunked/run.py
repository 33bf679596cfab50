"""A run on an image larger than memory: survey it, run in each chunk, join what crosses seams, find objects."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np

from cpm_core.chunked import image_statistics
from cpm_core.chunked.chunk_objects import MAX_OBJECT_SIDE, find_chunk_objects
from cpm_core.chunked.chunk_run import find_chunk_contours
from cpm_core.chunked.grid import Chunk, ChunkedSource, ChunkGrid, box_touches, build_grid, window_limits
from cpm_core.chunked.seams import find_duplicates, join_pieces, select_owned_contours
from cpm_core.chunked.store import ContourPiece, RunStore, pack_pieces, unpack_pieces
from cpm_core.contours.contour import Contour
from cpm_core.formats.common.provenance import VERSION
from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Array, Integers, JsonDict, frozen
from cpm_core.objects.partition import ParentImage
from cpm_core.parameters import Parameters
from cpm_core.reconstruction.curve.hysteresis import least_contour_length
from cpm_core.shapes.everywhere import SeedingKind

Compute = Callable[[Callable[[Any], Any], Sequence[Any], str], Iterable[tuple[int, Any]]]
"""Applies a function to jobs, in any order and on any workers, under a title; yields the index and result of each."""

STATISTICS_FILE = "whole.npz"
"""Name of the file with the statistics of the whole image."""

CONTOURS_KIND = "contours"
"""Kind of the files that hold the contours of chunks."""

OBJECTS_KIND = "objects"
"""Kind of the files that hold the objects of chunks."""


@frozen
class ChunkedTask:
    """A run to be done, and where its results are stored.

    Attributes
    ----------
    source : ChunkedSource
        The image.
    parameters : Parameters
        Parameters of the run.
    kind : str
        Kind of automatic seeding, one of `CHUNKED_START_KINDS`.
    store : RunStore
        Where results are stored.
    max_steps : int or None
        Greatest number of steps in each chunk.
    objects : bool
        Whether objects between the contours are found instead of contours.
    """

    source: ChunkedSource
    parameters: Parameters
    kind: SeedingKind
    store: RunStore
    max_steps: int | None = None
    objects: bool = False

    @property
    def settings(self) -> JsonDict:
        """All settings that the result depends on, besides the image."""
        return {"image": str(self.source.path.absolute()), "reading": asdict(self.source.reading), "start": self.kind,
                "parameters": asdict(self.parameters), "steps": self.max_steps, "objects": self.objects,
                "version": VERSION}  # fmt: skip


@frozen
class ChunkedContours:
    """Results of a run, which can be read chunk by chunk.

    Attributes
    ----------
    task : ChunkedTask
        The run.
    grid : ChunkGrid
        The chunks.
    statistics : ImageStatistics
        What the fields depend on in the whole image.
    counts : tuple of int
        Number of contours, or of objects, of each chunk.
    kind : str
        `CONTOURS_KIND` or `OBJECTS_KIND`; the contours of an object share its number as their `Contour.group`.
    """

    task: ChunkedTask
    grid: ChunkGrid
    statistics: image_statistics.ImageStatistics
    counts: Integers
    kind: str = CONTOURS_KIND

    def read_chunk_contours(self, chunk: int) -> list[Contour]:
        """Read the contours of a chunk, numbered through the image; last those that no chunk sees as a whole."""
        store, own = self.task.store, self.task.store.load(chunk_file_name(self.kind, chunk))
        known = store.load(f"{self.kind}.npz", "twice_chunk", "twice_at")
        again = known["twice_at"][known["twice_chunk"] == chunk]
        kept = np.setdiff1d(np.arange(len(own["boxes"])), again)
        number = np.zeros(len(own["boxes"]), np.int64)
        number[kept] = 1 + sum(self.counts[:chunk]) + np.arange(len(kept))
        pieces = zip(unpack_pieces(own, "whole_"), number[own["item"]].tolist(), strict=True)
        found = [_number_contour(piece.contour, number, self.kind) for piece, number in pieces if number]
        return found + self._read_long_contours(chunk)

    @property
    def count(self) -> int:
        """Number of contours, or of objects."""
        return sum(self.counts)

    def find_contours_near(self, window: Window) -> list[Contour]:
        """Read the contours that reach into a window."""
        numbers = self.grid.find_owners_near(window)
        found = [one for at in numbers for one in self.read_chunk_contours(at)]
        low, high = window_limits(window)
        long = self.task.store.load(f"{self.kind}.npz", "long", "chunk")
        there = ((long["long"][:, 1] >= low) & (long["long"][:, 0] <= high)).all(axis=1)
        found += [
            one for at in np.setdiff1d(long["chunk"][there], numbers).tolist() for one in self._read_long_contours(at)
        ]
        return [one for one in found if box_touches(one, window)]

    def _read_long_contours(self, chunk: int) -> list[Contour]:
        """Read the contours of a chunk that no chunk sees as a whole."""
        name = chunk_file_name("long", chunk)
        if self.kind == OBJECTS_KIND or not self.task.store.has_file(name):
            return []
        known = self.task.store.load(name)
        rows = zip(unpack_pieces(known, "long_"), known["number"].tolist(), strict=True)
        return [_number_contour(piece.contour, number, self.kind) for piece, number in rows]


def _number_contour(contour: Contour, number: int, kind: str) -> Contour:
    """Give a contour its number, or that of its object."""
    if kind == OBJECTS_KIND:
        return replace(contour, group=number, name=f"object {number}")
    return replace(contour, number=number)


def run_chunks(task: ChunkedTask, compute: Compute, side: int) -> ChunkedContours:
    """Find all contours or objects; what the store holds of a run with the same settings is not found again."""
    task.store.open_run({**task.settings, "side": side, "shape": task.source.shape})
    grid, whole = survey_image(task, compute, side)
    map_chunks(compute, partial(find_contours_in_chunk, task, grid, whole), task.store, grid.chunks, CONTOURS_KIND)
    least = max(least_contour_length(whole.scaling.smoothing, task.parameters), task.parameters.min_length)
    found = ChunkedContours(task, grid, whole, _join_across_seams(task.store, grid, least, CONTOURS_KIND))
    if whole.parent is None:
        return found
    map_chunks(compute, partial(find_objects_in_chunk, found, whole.parent), task.store, grid.chunks, OBJECTS_KIND)
    wide = replace(grid, max_whole_side=MAX_OBJECT_SIDE)
    return ChunkedContours(task, wide, whole, _join_across_seams(task.store, wide, 0.0, OBJECTS_KIND), OBJECTS_KIND)


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
    for _ in compute(process_chunk, todo, title or kind):
        pass


def survey_image(task: ChunkedTask, compute: Compute, side: int) -> tuple[ChunkGrid, image_statistics.ImageStatistics]:
    """Measure the statistics of the whole image, and divide the image into chunks."""
    source, parameters, shape = task.source, task.parameters, task.source.shape
    if task.store.has_file(STATISTICS_FILE):
        whole = image_statistics.ImageStatistics.from_arrays(task.store.load(STATISTICS_FILE), shape)
        return build_grid(shape, parameters, whole.scaling.smoothing, side), whole
    plain = ChunkGrid(shape, side, 0, 0.0)
    gray = sort_results(compute(partial(image_statistics.measure_gray_levels, source), plain.chunks, "gray levels"))
    tone = image_statistics.find_scaling(source, plain, gray, parameters)
    frame = image_statistics.build_parent_image(source, plain, gray) if task.objects else None
    grid = build_grid(shape, parameters, tone.smoothing, side)
    work = partial(image_statistics.measure_edges, source, tone=tone, parameters=parameters)
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
    """Find the contours of a chunk and store those that it keeps, unless a worker that died has done so."""
    if task.store.has_file(chunk_file_name(CONTOURS_KIND, chunk.number)):
        return
    found = find_chunk_contours(task.source, chunk, statistics, task.parameters, task.kind, task.max_steps)
    own, pieces = select_owned_contours(found, chunk, grid)
    boxes = [piece.contour.box for piece in own]
    _save_chunk(task.store, CONTOURS_KIND, chunk, boxes, range(len(own)), whole=own, piece=pieces)


def find_objects_in_chunk(found: ChunkedContours, parent: ParentImage, chunk: Chunk) -> None:
    """Find the objects between contours in a chunk and store them, unless a worker that died has done so."""
    store = found.task.store
    if store.has_file(chunk_file_name(OBJECTS_KIND, chunk.number)):
        return
    objects = list(find_chunk_objects(found.task.source, found.find_contours_near, chunk, parent))
    own = [ContourPiece(contour) for _, contours in objects for contour in contours]
    items = [at for at, (_, contours) in enumerate(objects) for _ in contours]
    _save_chunk(store, OBJECTS_KIND, chunk, [box for box, _ in objects], items, whole=own, piece=[])


def _save_chunk(
    store: RunStore,
    kind: str,
    chunk: Chunk,
    boxes: Sequence[Array],
    items: Sequence[int],
    **pieces: Sequence[ContourPiece],
) -> None:
    """Store the boxes of what a chunk keeps, its contours with the numbers of their boxes, and pieces of others."""
    arrays = {f"{prefix}_{key}": values for prefix, some in pieces.items() for key, values in pack_pieces(some).items()}
    where = np.array(boxes, float).reshape(-1, 2, 2)
    store.save(chunk_file_name(kind, chunk.number), boxes=where, item=np.array(items, np.int64), **arrays)


def chunk_file_name(kind: str, number: int) -> str:
    """Return the name of the file of a chunk that holds results of a kind."""
    return f"{kind}_{number}.npz"


def _join_across_seams(store: RunStore, grid: ChunkGrid, least: float, kind: str) -> Integers:
    """Join what crosses seams to contours of at least a length, store them, and return the count of each chunk."""
    boxes: list[Array] = []
    pieces: list[ContourPiece] = []
    of_piece: list[int] = []
    count = len(grid.chunks)
    for number in range(count):
        known = store.load(chunk_file_name(kind, number))
        boxes.append(known["boxes"])
        some = unpack_pieces(known, "piece_")
        pieces += some
        of_piece += [number] * len(some)
    sizes = np.array([len(some) for some in boxes])
    chunks = np.repeat(np.arange(count), sizes)
    again = np.flatnonzero(find_duplicates(np.concatenate(boxes), chunks, grid))
    long = join_pieces(pieces, of_piece, least) if pieces else []
    extents = np.array([one.box for one in long]).reshape(-1, 2, 2)
    at = grid.find_chunk_numbers(extents.mean(axis=1))
    first, alone = np.cumsum(sizes) - sizes, sizes - np.bincount(chunks[again], minlength=count)
    counts = alone + np.bincount(at, minlength=count)
    for chunk in np.unique(at).tolist():
        own = [ContourPiece(long[n]) for n in np.flatnonzero(at == chunk)]
        number = 1 + counts[:chunk].sum() + alone[chunk] + np.arange(len(own))
        arrays = {f"long_{key}": values for key, values in pack_pieces(own).items()}
        store.save(chunk_file_name("long", chunk), number=number, **arrays)
    store.save(f"{kind}.npz", twice_chunk=chunks[again], twice_at=again - first[chunks[again]], long=extents, chunk=at)
    return tuple(counts.tolist())
