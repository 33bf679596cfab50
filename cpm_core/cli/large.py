"""The branch of ``cpm run`` for an image larger than memory, which is run chunk by chunk."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from cpm_core.chunked import grid, results, volume_results
from cpm_core.chunked.chunk_run import CHUNKED_START_KINDS
from cpm_core.chunked.run import ChunkedTask, run_chunks
from cpm_core.chunked.store import RunStore
from cpm_core.chunked.volume_surface import run_volume
from cpm_core.cli.arguments import check_targets, parse_number_or_text, refuse_options
from cpm_core.cli.output import OutputFiles, StatusLine, ensure_compiled, print_notes, print_report
from cpm_core.cli.workers import connect_to_dask, map_until_finished, run_on_one_core
from cpm_core.field.volume_field import check_volume_parameters
from cpm_core.formats.common.atomic import find_suffix
from cpm_core.formats.images.ome_zarr import is_zarr, open_multiscale
from cpm_core.formats.images.reading import Reading
from cpm_core.image.colors import LUMINANCE_CHOICE
from cpm_core.numerics.types import JsonObject
from cpm_core.parameters import Parameters
from cpm_core.parameters.formatting import format_count, format_size
from cpm_core.segmentation.reach.reach_map import is_limited

_WHOLE_IMAGE_PURPOSE = "an image that is run in one piece"
"""What options are for that are refused here."""

_CHUNK_FOLDER_SUFFIX = ".cpm-chunks"
"""Suffix of the folder for intermediate results, next to the first exported file."""


def is_large(arguments: argparse.Namespace, path: Path) -> bool:
    """Tell whether a run works chunk by chunk: everywhere in an image whose format can be read in parts."""
    return bool(arguments.auto) and is_zarr(path)


def is_large_volume(arguments: argparse.Namespace) -> bool:
    """Tell whether such an image has several planes, none of which is named."""
    path = Path(arguments.image or "")
    series: Any = arguments.series and parse_number_or_text(arguments.series)
    if arguments.page or arguments.pages or not is_large(arguments, path):
        return False
    return open_multiscale(path, Reading(series=series)).axis_length("z") > 1


def run_large(
    arguments: argparse.Namespace, path: Path, part: JsonObject, parameters: Parameters, *, volume: bool = False
) -> int:
    """Find contours, or in a volume bodies, chunk by chunk; the same command continues an interrupted run."""
    drawn = ("session", "circle", "stroke", "points", "start", "region", "barrier", "object", "not", "pages", "truth")
    refuse_options(arguments, (*drawn, "sphere", "space", "save_session"), _WHOLE_IMAGE_PURPOSE)
    files_of: Any = volume_results if volume else results
    _check_chunked_run(arguments, path, parameters, files_of.WRITABLE)
    if volume:
        check_volume_parameters(parameters)
        if parameters.gamma != 1.0:
            raise ValueError("--gamma looks at the whole volume at once: leave it at 1, or run a smaller volume.")
    source = grid.ChunkedSource(path, Reading(**part), "zyx" if volume else "yx")
    first = Path(arguments.export[0])
    store = RunStore(first.with_name(f"{first.name}{_CHUNK_FOLDER_SUFFIX}"))
    task = ChunkedTask(source, parameters, arguments.auto, store, arguments.max_steps, arguments.objects)
    began, channels = time.perf_counter(), source.levels.axis_length("c")
    if channels > 1 and source.reading.channel is None:
        print_notes(source.levels.name, [f"Only the first of its {channels} channels was taken."])
    ensure_compiled()
    with connect_to_dask(arguments.scheduler, arguments.workers) as client, StatusLine() as line:

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

        found: Any = run_volume(task, compute_chunks) if volume else run_chunks(task, compute_chunks, grid.CHUNK_SIDE)
        files = OutputFiles()
        files.written += results.write_results(found, arguments.export, compute_chunks, files_of.WRITERS)
    store.remove()
    seconds, chunks = time.perf_counter() - began, len(found.grid.chunks)
    smoothing, unit = found.statistics.scaling.smoothing, "voxels" if volume else "px"
    facts = {found.kind: found.count, "chunks": chunks, "seconds": round(seconds, 3), "smoothing": smoothing}
    noun = {"bodies": "body"}.get(found.kind, found.kind[:-1])
    lines = [
        f"{source.levels.name}: {format_count(found.count, noun, found.kind)} in {format_size(found.grid.shape, unit)}",
        f"{format_count(chunks, 'chunk')} in {seconds:.1f} s, smoothing {smoothing:g} {unit}",
    ]
    return print_report(arguments, facts, lines, files)


def _check_chunked_run(
    arguments: argparse.Namespace, path: Path, parameters: Parameters, writable: Mapping[str, str]
) -> None:
    """Raise ValueError for what does not work chunk by chunk."""
    if arguments.auto not in CHUNKED_START_KINDS:
        raise ValueError(
            f"--auto is {arguments.auto}, which looks at the whole image: use one of {', '.join(CHUNKED_START_KINDS)}."
        )
    if parameters.channel != LUMINANCE_CHOICE:
        raise ValueError(f"--channel is {parameters.channel}, but its channels have numbers: give one from 1.")
    if parameters.edges == "vessels":
        raise ValueError("--edges vessels looks at the whole image at once: use gradient, or a smaller image.")
    if is_limited(parameters):
        raise ValueError("--reach and --weakest-edge are for a start that is drawn: leave them out.")
    if not arguments.export:
        raise ValueError(f"--export is missing: name files that end in {', '.join(writable)}.")
    for target in arguments.export:
        if not find_suffix(target, writable):
            raise ValueError(f"{target} cannot be written chunk by chunk: choose one of {', '.join(writable)}.")
        if Path(target).is_dir() and not is_zarr(Path(target)):
            raise ValueError(f"{target} is a folder, which would be replaced: choose another name.")
        if not Path(target).absolute().parent.is_dir():
            raise ValueError(f"{target} cannot be written: there is no such folder.")
    check_targets(arguments.export, arguments, path)
