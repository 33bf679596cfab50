"""A run on an image larger than memory: look at the whole, run in each chunk, join what crosses seams."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import numpy as np

from cpm_core.chunked import survey
from cpm_core.chunked.chunk_run import contours_in
from cpm_core.chunked.grid import Chunk, Grid, Source, grid_for
from cpm_core.chunked.seams import joined, owned, twice
from cpm_core.chunked.store import Piece, Store, packed, unpacked
from cpm_core.contours.contour import Contour
from cpm_core.formats.common.provenance import VERSION
from cpm_core.numerics.types import Array, Entries, Integers, frozen
from cpm_core.parameters import Parameters
from cpm_core.reconstruction.curve.hysteresis import shortest
from cpm_core.shapes.everywhere import Kind

Compute = Callable[[Callable[[Any], Any], Sequence[Any], str], Iterable[tuple[int, Any]]]
"""Applies a function to each of some jobs, in any order and on any workers, under a title: gives index and result."""

_WHOLE, _JOINED = "whole.npz", "joined.npz"


@frozen
class Task:
    """What is to be found, and where it is stored.

    Attributes
    ----------
    source : Source
        The image.
    parameters : Parameters
        Of the run.
    kind : str
        Automatic seeding, one of `chunk_run.KINDS`.
    store : Store
        Where results are put.
    max_steps : int or None
        Greatest number of steps in each chunk.
    """

    source: Source
    parameters: Parameters
    kind: Kind
    store: Store
    max_steps: int | None = None

    @property
    def settings(self) -> Entries:
        """All that the result depends on, but the image."""
        return {"image": str(self.source.path.absolute()), "reading": asdict(self.source.reading), "start": self.kind,
                "parameters": asdict(self.parameters), "steps": self.max_steps, "version": VERSION}  # fmt: skip


@frozen
class Found:
    """What has been found, of which each chunk can be read by itself.

    Attributes
    ----------
    task : Task
        What was to be found.
    grid : Grid
        The chunks.
    whole : Whole
        What the fields were measured by.
    counts : tuple of int
        Number of contours of each chunk.
    """

    task: Task
    grid: Grid
    whole: survey.Whole
    counts: Integers

    def contours(self, chunk: int) -> list[Contour]:
        """The contours of a chunk, numbered through the image; last those that no chunk sees as a whole."""
        own = unpacked(self.task.store.load(_chunk(chunk)), "whole_")
        known = self.task.store.load(_JOINED)
        again = set(known["twice_at"][known["twice_chunk"] == chunk].tolist())
        contours = [piece.contour for at, piece in enumerate(own) if at not in again]
        first = 1 + sum(self.counts[:chunk])
        numbered = [replace(one, number=number) for number, one in enumerate(contours, start=first)]
        return numbered + [one for one, at in zip(_long(known), known["chunk"].tolist(), strict=True) if at == chunk]

    @property
    def count(self) -> int:
        """Number of contours."""
        return sum(self.counts)

    @property
    def long(self) -> list[Contour]:
        """The contours that no chunk sees as a whole."""
        return _long(self.task.store.load(_JOINED))


def _long(known: Entries) -> list[Contour]:
    rows = zip(unpacked(known, "long_"), known["number"].tolist(), strict=True)
    return [replace(piece.contour, number=number) for piece, number in rows]


def run(task: Task, compute: Compute, side: int) -> Found:
    """Find all contours; what is in the store from an earlier run with the same settings is not found again."""
    task.store.begin({**task.settings, "side": side, "shape": task.source.shape})
    grid, whole = surveyed(task, compute, side)
    todo = [chunk for chunk in grid.chunks if not task.store.has(_chunk(chunk.number))]
    for _ in compute(partial(find, task, grid, whole), todo, "contours"):
        pass
    least = max(shortest(whole.tone.smoothing, task.parameters), task.parameters.min_length)
    return Found(task, grid, whole, _join(task.store, grid, least))


def surveyed(task: Task, compute: Compute, side: int) -> tuple[Grid, survey.Whole]:
    """The chunks of an image, and what depends on all of it."""
    source, parameters, shape = task.source, task.parameters, task.source.shape
    if task.store.has(_WHOLE):
        whole = survey.Whole.of(task.store.load(_WHOLE))
        return grid_for(shape, parameters, whole.tone.smoothing, side), whole
    tone = survey.plain_tone(shape, parameters)
    if tone is None:
        plain = Grid(shape, side, 0, 0.0)
        gray = in_order(compute(partial(survey.gray_levels, source), plain.chunks, "gray levels"))
        tone = survey.tone_of(source, plain, gray, parameters)
    grid = grid_for(shape, parameters, tone.smoothing, side)
    work = partial(survey.edges, source, tone=tone, parameters=parameters)
    whole = survey.whole_of(tone, in_order(compute(work, grid.chunks, "edges")), parameters)
    task.store.save(_WHOLE, **whole.numbers)
    return grid, whole


def in_order(results: Iterable[tuple[int, Any]]) -> list[Any]:
    """Results in the order of their jobs."""
    return [result for _, result in sorted(results, key=lambda one: one[0])]


def find(task: Task, grid: Grid, whole: survey.Whole, chunk: Chunk) -> None:
    """Find the contours of a chunk and store what it keeps of them, unless a worker that died has done so."""
    if task.store.has(_chunk(chunk.number)):
        return
    found = contours_in(task.source, chunk, whole, task.parameters, task.kind, task.max_steps)
    own, pieces = owned(found, chunk, grid)
    boxes = np.array([piece.contour.box for piece in own]).reshape(-1, 2, 2)
    arrays = {f"{prefix}_{key}": values for prefix, some in (("whole", own), ("piece", pieces))
              for key, values in packed(some).items()}  # fmt: skip
    task.store.save(_chunk(chunk.number), boxes=boxes, **arrays)


def _chunk(number: int) -> str:
    return f"chunk_{number}.npz"


def _join(store: Store, grid: Grid, least: float) -> Integers:
    """Join what crosses seams to contours of some length, store it, and give the number of contours of each chunk."""
    boxes: list[Array] = []
    pieces: list[Piece] = []
    of_piece: list[int] = []
    count = len(grid.chunks)
    for number in range(count):
        known = store.load(_chunk(number))
        boxes.append(known["boxes"])
        some = unpacked(known, "piece_")
        pieces += some
        of_piece += [number] * len(some)
    sizes = np.array([len(some) for some in boxes])
    chunks = np.repeat(np.arange(count), sizes)
    again = np.flatnonzero(twice(np.concatenate(boxes), chunks, grid))
    long = joined(pieces, of_piece, least) if pieces else []
    at = grid.chunk_at(np.array([one.box.mean(axis=0) for one in long]).reshape(-1, 2))
    order = np.argsort(at, kind="stable")
    at, long = at[order], [long[n] for n in order]
    first, alone = np.cumsum(sizes) - sizes, sizes - np.bincount(chunks[again], minlength=count)
    counts = alone + np.bincount(at, minlength=count)
    rank = np.arange(len(at)) - np.searchsorted(at, at)
    store.save(
        _JOINED,
        twice_chunk=chunks[again],
        twice_at=again - first[chunks[again]],
        chunk=at,
        number=1 + (np.cumsum(counts) - counts + alone)[at] + rank,
        **{f"long_{key}": values for key, values in packed([Piece(one) for one in long]).items()},
    )
    return tuple(counts.tolist())
