"""The branch of ``cpm run`` for an image larger than memory, which is run chunk by chunk."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from cpm_core.chunked import grid, results, volume_results
from cpm_core.chunked.chunked_contours import ChunkedTask
from cpm_core.chunked.run import run_chunks
from cpm_core.chunked.store import RunStore
from cpm_core.chunked.volume_objects import run_volume
from cpm_core.cli.output import OutputFiles, StatusLine, ensure_compiled, print_notes, print_report
from cpm_core.cli.run_request import RunRequest
from cpm_core.cli.workers import connect_to_dask, map_until_finished, run_on_one_core
from cpm_core.formats.images.reading import Reading
from cpm_core.parameters.formatting import format_count, format_size

_CHUNK_FOLDER_SUFFIX = ".cpm-chunks"
"""Suffix of the folder for intermediate results, next to the first exported file."""


def run_large(request: RunRequest) -> int:
    """Find contours, or in a volume bodies, chunk by chunk; the same command continues an interrupted run."""
    assert request.seeding is not None
    files_of: Any = volume_results if request.is_volume else results
    source = grid.ChunkedSource(request.path, Reading(**request.part), "zyx" if request.is_volume else "yx")
    first = Path(request.exports[0])
    store = RunStore(first.with_name(f"{first.name}{_CHUNK_FOLDER_SUFFIX}"))
    task = ChunkedTask(source, request.parameters, request.seeding, store, request.max_steps, request.all_objects)
    began, channels = time.perf_counter(), source.levels.axis_length("c")
    if channels > 1 and source.reading.channel is None:
        print_notes(source.levels.name, [f"Only the first of its {channels} channels was taken."])
    ensure_compiled()
    with connect_to_dask(request.scheduler, request.workers) as client, StatusLine() as line:

        def compute_chunks(
            function: Callable[[Any], Any], jobs: Sequence[Any], title: str
        ) -> Iterator[tuple[int, Any]]:
            line.begin_count(title)
            for done, (at, future) in enumerate(
                map_until_finished(client, partial(run_on_one_core, function), jobs), start=1
            ):
                result = future.result()
                line.show_count(done, len(jobs))
                yield at, result

        found: Any = (
            run_volume(task, compute_chunks) if request.is_volume else run_chunks(task, compute_chunks, grid.CHUNK_SIDE)
        )
        files = OutputFiles()
        files.written += results.write_results(found, request.exports, compute_chunks, files_of.WRITERS)
    store.remove()
    seconds, chunks = time.perf_counter() - began, len(found.grid.chunks)
    smoothing, unit = found.statistics.scaling.smoothing, "voxels" if request.is_volume else "px"
    facts = {found.kind: found.count, "chunks": chunks, "seconds": round(seconds, 3), "smoothing": smoothing}
    noun = {"bodies": "body"}.get(found.kind, found.kind[:-1])
    lines = [
        f"{source.levels.name}: {format_count(found.count, noun, found.kind)} in {format_size(found.grid.shape, unit)}",
        f"{format_count(chunks, 'chunk')} in {seconds:.1f} s, smoothing {smoothing:g} {unit}",
    ]
    return print_report("run", request.as_json, facts, lines, files)
