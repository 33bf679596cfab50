"""A run on an image larger than memory: survey it, run in each chunk, join what crosses seams, find objects."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np

from cpm_core.chunked import survey
from cpm_core.chunked.chunk_objects import LONGEST, objects_in
from cpm_core.chunked.chunk_run import contours_in
from cpm_core.chunked.grid import Chunk, Grid, Source, grid_for, limits, touches
from cpm_core.chunked.seams import joined, owned, twice
from cpm_core.chunked.store import Piece, Store, packed, unpacked
from cpm_core.contours.contour import Contour
from cpm_core.formats.common.provenance import VERSION
from cpm_core.numerics.grids import Window
from cpm_core.numerics.types import Array, JsonDict, Integers, frozen
from cpm_core.objects.partition import Frame
from cpm_core.parameters import Parameters
from cpm_core.reconstruction.curve.hysteresis import least_contour_length
from cpm_core.shapes.everywhere import SeedingKind

Compute = Callable[[Callable[[Any], Any], Sequence[Any], str], Iterable[tuple[int, Any]]]
"""Applies a function to jobs, in any order and on any workers, under a title; yields the index and result of each."""

WHOLE = "whole.npz"
"""Name of the file with the statistics of the whole image."""

CONTOURS = "contours"
"""Kind of the files that hold the contours of chunks."""

OBJECTS = "objects"
"""Kind of the files that hold the objects of chunks."""


@frozen
class Task:
    """A run to be done, and where its results are stored.

    Attributes
    ----------
    source : Source
        The image.
    parameters : Parameters
        Parameters of the run.
    kind : str
        Kind of automatic seeding, one of `chunk_run.KINDS`.
    store : Store
        Where results are stored.
    max_steps : int or None
        Greatest number of steps in each chunk.
    objects : bool
        Whether objects between the contours are found instead of contours.
    """

    source: Source
    parameters: Parameters
    kind: SeedingKind
    store: Store
    max_steps: int | None = None
    objects: bool = False

    @property
    def settings(self) -> JsonDict:
        """All settings that the result depends on, besides the image."""
        return {"image": str(self.source.path.absolute()), "reading": asdict(self.source.reading), "start": self.kind,
                "parameters": asdict(self.parameters), "steps": self.max_steps, "objects": self.objects,
                "version": VERSION}  # fmt: skip


@frozen
class Found:
    """Results of a run, which can be read chunk by chunk.

    Attributes
    ----------
    task : Task
        The run.
    grid : Grid
        The chunks.
    whole : Whole
        What the fields depend on in the whole image.
    counts : tuple of int
        Number of contours, or of objects, of each chunk.
    kind : str
        `CONTOURS` or `OBJECTS`; the contours of an object share its number as their `Contour.group`.
    """

    task: Task
    grid: Grid
    whole: survey.Whole
    counts: Integers
    kind: str = CONTOURS

    def contours(self, chunk: int) -> list[Contour]:
        """Read the contours of a chunk, numbered through the image; last those that no chunk sees as a whole."""
        store, own = self.task.store, self.task.store.load(of_chunk(self.kind, chunk))
        known = store.load(f"{self.kind}.npz", "twice_chunk", "twice_at")
        again = known["twice_at"][known["twice_chunk"] == chunk]
        kept = np.setdiff1d(np.arange(len(own["boxes"])), again)
        number = np.zeros(len(own["boxes"]), np.int64)
        number[kept] = 1 + sum(self.counts[:chunk]) + np.arange(len(kept))
        pieces = zip(unpacked(own, "whole_"), number[own["item"]].tolist(), strict=True)
        found = [_numbered(piece.contour, number, self.kind) for piece, number in pieces if number]
        return found + self._long(chunk)

    @property
    def count(self) -> int:
        """Number of contours, or of objects."""
        return sum(self.counts)

    def near(self, window: Window) -> list[Contour]:
        """Read the contours that reach into a window."""
        numbers = self.grid.near(window)
        found = [one for at in numbers for one in self.contours(at)]
        low, high = limits(window)
        long = self.task.store.load(f"{self.kind}.npz", "long", "chunk")
        there = ((long["long"][:, 1] >= low) & (long["long"][:, 0] <= high)).all(axis=1)
        found += [one for at in np.setdiff1d(long["chunk"][there], numbers).tolist() for one in self._long(at)]
        return [one for one in found if touches(one, window)]

    def _long(self, chunk: int) -> list[Contour]:
        """Read the contours of a chunk that no chunk sees as a whole."""
        name = of_chunk("long", chunk)
        if self.kind == OBJECTS or not self.task.store.has(name):
            return []
        known = self.task.store.load(name)
        rows = zip(unpacked(known, "long_"), known["number"].tolist(), strict=True)
        return [_numbered(piece.contour, number, self.kind) for piece, number in rows]


def _numbered(contour: Contour, number: int, kind: str) -> Contour:
    """Give a contour its number, or that of its object."""
    if kind == OBJECTS:
        return replace(contour, group=number, name=f"object {number}")
    return replace(contour, number=number)


def run(task: Task, compute: Compute, side: int) -> Found:
    """Find all contours or objects; what the store holds of a run with the same settings is not found again."""
    task.store.begin({**task.settings, "side": side, "shape": task.source.shape})
    grid, whole = surveyed(task, compute, side)
    in_each(compute, partial(find, task, grid, whole), task.store, grid.chunks, CONTOURS)
    least = max(least_contour_length(whole.tone.smoothing, task.parameters), task.parameters.min_length)
    found = Found(task, grid, whole, _join(task.store, grid, least, CONTOURS))
    if whole.frame is None:
        return found
    in_each(compute, partial(find_objects, found, whole.frame), task.store, grid.chunks, OBJECTS)
    wide = replace(grid, whole=LONGEST)
    return Found(task, wide, whole, _join(task.store, wide, 0.0, OBJECTS), OBJECTS)


def in_each(
    compute: Compute, work: Callable[[Chunk], None], store: Store, chunks: Iterable[Chunk], kind: str, title: str = ""
) -> None:
    """Process each of some chunks that has no file of a kind yet."""
    todo = [chunk for chunk in chunks if not store.has(of_chunk(kind, chunk.number))]
    for _ in compute(work, todo, title or kind):
        pass


def surveyed(task: Task, compute: Compute, side: int) -> tuple[Grid, survey.Whole]:
    """Measure the statistics of the whole image, and divide the image into chunks."""
    source, parameters, shape = task.source, task.parameters, task.source.shape
    if task.store.has(WHOLE):
        whole = survey.Whole.of(task.store.load(WHOLE), shape)
        return grid_for(shape, parameters, whole.tone.smoothing, side), whole
    tone, frame = survey.plain_tone(shape, parameters), None
    if tone is None or task.objects:
        plain = Grid(shape, side, 0, 0.0)
        gray = in_order(compute(partial(survey.gray_levels, source), plain.chunks, "gray levels"))
        tone = tone or survey.tone_of(source, plain, gray, parameters)
        frame = survey.frame_of(source, plain, gray) if task.objects else None
    grid = grid_for(shape, parameters, tone.smoothing, side)
    work = partial(survey.edges, source, tone=tone, parameters=parameters)
    whole = survey.whole_of(tone, in_order(compute(work, grid.chunks, "edges")), parameters, frame)
    task.store.save(WHOLE, **whole.numbers)
    return grid, whole


def in_order(results: Iterable[tuple[int, Any]]) -> list[Any]:
    """Sort results by the order of their jobs."""
    return [result for _, result in sorted(results, key=lambda one: one[0])]


def find(task: Task, grid: Grid, whole: survey.Whole, chunk: Chunk) -> None:
    """Find the contours of a chunk and store those that it keeps, unless a worker that died has done so."""
    if task.store.has(of_chunk(CONTOURS, chunk.number)):
        return
    found = contours_in(task.source, chunk, whole, task.parameters, task.kind, task.max_steps)
    own, pieces = owned(found, chunk, grid)
    boxes = [piece.contour.box for piece in own]
    _save(task.store, CONTOURS, chunk, boxes, range(len(own)), whole=own, piece=pieces)


def find_objects(found: Found, frame: Frame, chunk: Chunk) -> None:
    """Find the objects between contours in a chunk and store them, unless a worker that died has done so."""
    store = found.task.store
    if store.has(of_chunk(OBJECTS, chunk.number)):
        return
    objects = list(objects_in(found.task.source, found.near, chunk, frame))
    own = [Piece(contour) for _, contours in objects for contour in contours]
    items = [at for at, (_, contours) in enumerate(objects) for _ in contours]
    _save(store, OBJECTS, chunk, [box for box, _ in objects], items, whole=own, piece=[])


def _save(
    store: Store, kind: str, chunk: Chunk, boxes: Sequence[Array], items: Sequence[int], **pieces: Sequence[Piece]
) -> None:
    """Store the boxes of what a chunk keeps, its contours with the numbers of their boxes, and pieces of others."""
    arrays = {f"{prefix}_{key}": values for prefix, some in pieces.items() for key, values in packed(some).items()}
    where = np.array(boxes, float).reshape(-1, 2, 2)
    store.save(of_chunk(kind, chunk.number), boxes=where, item=np.array(items, np.int64), **arrays)


def of_chunk(kind: str, number: int) -> str:
    """Return the name of the file of a chunk that holds results of a kind."""
    return f"{kind}_{number}.npz"


def _join(store: Store, grid: Grid, least: float, kind: str) -> Integers:
    """Join what crosses seams to contours of at least a length, store them, and return the count of each chunk."""
    boxes: list[Array] = []
    pieces: list[Piece] = []
    of_piece: list[int] = []
    count = len(grid.chunks)
    for number in range(count):
        known = store.load(of_chunk(kind, number))
        boxes.append(known["boxes"])
        some = unpacked(known, "piece_")
        pieces += some
        of_piece += [number] * len(some)
    sizes = np.array([len(some) for some in boxes])
    chunks = np.repeat(np.arange(count), sizes)
    again = np.flatnonzero(twice(np.concatenate(boxes), chunks, grid))
    long = joined(pieces, of_piece, least) if pieces else []
    extents = np.array([one.box for one in long]).reshape(-1, 2, 2)
    at = grid.chunk_at(extents.mean(axis=1))
    first, alone = np.cumsum(sizes) - sizes, sizes - np.bincount(chunks[again], minlength=count)
    counts = alone + np.bincount(at, minlength=count)
    for chunk in np.unique(at).tolist():
        own = [Piece(long[n]) for n in np.flatnonzero(at == chunk)]
        number = 1 + counts[:chunk].sum() + alone[chunk] + np.arange(len(own))
        arrays = {f"long_{key}": values for key, values in packed(own).items()}
        store.save(of_chunk("long", chunk), number=number, **arrays)
    store.save(f"{kind}.npz", twice_chunk=chunks[again], twice_at=again - first[chunks[again]], long=extents, chunk=at)
    return tuple(counts.tolist())
