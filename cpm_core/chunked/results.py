"""Files of the results of a run chunk by chunk: a label image, tiles of GeoJSON, and a table."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cpm_core.chunked.chunked_contours import ChunkedContours, ChunkedTask
from cpm_core.chunked.grid import Chunk, ChunkedSource, ChunkGrid, window_limits
from cpm_core.chunked.run import Compute
from cpm_core.contours.contour import Contour
from cpm_core.contours.measurements import assign_labels
from cpm_core.contours.rasterize import rasterize_labels
from cpm_core.contours.region_table import measure_regions
from cpm_core.formats.common.atomic import write_together
from cpm_core.formats.common.json_values import encode_json
from cpm_core.formats.common.provenance import PROVENANCE_KEY, describe_provenance, describe_shapes
from cpm_core.formats.contours.geojson import build_features
from cpm_core.formats.images.ome_zarr import create_multiscale, halve_window, write_window
from cpm_core.formats.images.resolution import name_column
from cpm_core.numerics.grids import Window, expand_window, first_pixel, rank_values, split_into_tiles, window_shape
from cpm_core.numerics.types import NO_POINTS, Array
from cpm_core.parameters.formatting import format_count
from cpm_core.parameters.provenance import Provenance, select_parameters
from cpm_core.results.result import Result
from cpm_core.segmentation.engine import Engine
from cpm_core.shapes import Everywhere


def write_results(
    found: Any, paths: Sequence[str], compute: Compute, writers: Mapping[str, Callable[..., str | None]]
) -> list[str]:
    """Write files by their suffixes, and return the name of each file, or of all its tiles.

    Writers take what was found, a path, a draft to write to until all is written, and how jobs are computed; they
    return the name where it is not the path.
    """
    written = []
    for path in map(Path, paths):
        with _open_draft(path) as draft:
            written.append(writers[path.suffix.lower()](found, path, draft, compute) or str(path))
    return written


@contextmanager
def _open_draft(path: Path) -> Iterator[Path]:
    """Open a place next to a file or a folder, which it replaces at the end."""
    draft = path.with_name(f".cpm-{path.name}.part")
    shutil.rmtree(draft, ignore_errors=True)
    yield draft
    if draft.exists():
        if path.is_dir():
            shutil.rmtree(path)
        draft.replace(path)


def write_label_image(found: ChunkedContours, _: Path, draft: Path, compute: Compute) -> None:
    """Write a label image in levels of resolution."""
    build_label_image(found.task.source, found.grid, draft, partial(_paint_chunk_labels, found, draft), compute)


def build_label_image(
    source: ChunkedSource, grid: ChunkGrid, path: Path, paint: Callable[[Chunk], None], compute: Compute
) -> None:
    """Write a label image in levels of resolution; `rasterize_labels` writes the finest in the core of each chunk."""
    more = {"image-label": {"version": "0.5"}}
    count = create_multiscale(path, grid.shape, np.uint32, grid.side, source.levels.spacing, source.levels.unit, more)
    _wait_for_jobs(compute(paint, grid.chunks, "labels"))
    for level in range(1, count):
        shape = tuple(-(-n // 2**level) for n in grid.shape)
        _wait_for_jobs(
            compute(partial(halve_window, path, level), split_into_tiles(shape, grid.side), "levels of labels")
        )


def _paint_chunk_labels(found: ChunkedContours, path: Path, chunk: Chunk) -> None:
    """Write the labels in the core of a chunk, which are the numbers of the contours, or of objects."""
    contours = [one for one in found.find_contours_near(chunk.core) if one.closed]
    if contours:
        labels = rasterize_labels(_shift_contours(contours, chunk.core), window_shape(chunk.core))
        numbers, (known, ranks) = _number_labels(contours), rank_values(labels)
        painted = np.array([numbers.get(label, 0) for label in known.tolist()], np.uint32)[ranks]
        write_window(path, chunk.core, painted)


def _number_labels(contours: Sequence[Contour]) -> dict[int, int]:
    """Return the number of each label that `rasterize_labels` gives to contours, in the order of `measure_regions`."""
    labels = assign_labels(contours)
    return {label: one.group or one.number for one, label in zip(contours, labels, strict=True) if label}


def _shift_contours(contours: Sequence[Contour], window: Window) -> list[Contour]:
    """Shift contours to px of a window."""
    corner = first_pixel(window)
    return [Contour(one.points - corner, one.closed, group=one.group, hole=one.hole) for one in contours]


def write_geojson_tiles(found: ChunkedContours, path: Path, _: Path, compute: Compute) -> str:
    """Write a file of GeoJSON for each chunk with contours."""
    count = sum(some for _, some in compute(partial(_write_tile, found, path), found.grid.chunks, "GeoJSON"))
    return f"{path.with_stem(f'{path.stem}_*')} ({format_count(count, 'file')})"


def _write_tile(found: ChunkedContours, path: Path, chunk: Chunk) -> bool:
    """Write the contours of a chunk, and return whether there are any."""
    own = found.read_chunk_contours(chunk.number)
    if not own:
        return False
    result = _build_result(found, _add_inner_contours(found, chunk, own))
    features = build_features(result)[: sum(not one.hole for one in own)]
    name = path.with_stem(f"{path.stem}_{chunk.core[0].start}_{chunk.core[1].start}")
    write_together(
        [
            (
                name,
                encode_json(
                    {"type": "FeatureCollection", PROVENANCE_KEY: describe_provenance(result), "features": features}
                ),
            )
        ]
    )
    return True


def _add_inner_contours(found: ChunkedContours, chunk: Chunk, own: Sequence[Contour]) -> list[Contour]:
    """Add the contours of other chunks that may lie in one of a chunk."""
    mine = {one.group or one.number for one in own}
    return [
        *own,
        *(
            one
            for one in found.find_contours_near(_find_window_around(found, chunk, own))
            if (one.group or one.number) not in mine
        ),
    ]


def _find_window_around(found: ChunkedContours, chunk: Chunk, contours: Sequence[Contour]) -> Window:
    """Find the pixels around contours of a chunk, as far as it has neighbors."""
    boxes, limits = (
        np.array([one.box for one in contours]),
        expand_window(chunk.core, found.grid.side, found.grid.shape),
    )
    low, high = np.floor(boxes[:, 0].min(axis=0)).astype(int), np.ceil(boxes[:, 1].max(axis=0)).astype(int) + 1
    ends = zip(low.tolist(), high.tolist(), limits, strict=True)
    return tuple(slice(max(first, side.start), min(last, side.stop)) for first, last, side in ends)


def _build_result(found: ChunkedContours, contours: Sequence[Contour]) -> Result:
    """Build a result of some contours, for writers."""
    task, levels = found.task, found.task.source.levels
    made = build_provenance(task)
    return Result(
        NO_POINTS, tuple(contours), None, 0, True, "run chunk by chunk", found.grid.shape, levels.spacing[1:],
        levels.unit, levels.name, provenance=made,
    )  # fmt: skip


def build_provenance(task: ChunkedTask) -> Provenance:
    """Build the provenance of what a task finds."""
    return Provenance(
        "cpm", select_parameters(task.parameters, Engine.parameters), None, describe_shapes([Everywhere(task.kind)]), 0
    )


def write_contour_table(found: ChunkedContours, path: Path, draft: Path, compute: Compute) -> None:
    """Write a table, with a row for each closed contour."""
    write_table_parts(path, draft, _in_order(compute(partial(_build_table_columns, found), found.grid.chunks, "table")))


def _in_order(results: Iterable[tuple[int, Any]]) -> Iterator[Any]:
    """Put results in the order of their jobs."""
    early, following = {}, 0
    for at, result in results:
        early[at] = result
        while following in early:
            yield early.pop(following)
            following += 1


def write_table_parts(path: Path, draft: Path, parts: Iterable[Mapping[str, Array]]) -> None:
    """Write a table whose parts have the same columns to a draft, in the format of the suffix of its path.

    A number that is not known, NaN, is an empty cell.
    """
    import pyarrow
    from pyarrow import csv, parquet

    make = parquet.ParquetWriter if path.suffix.lower() == ".parquet" else csv.CSVWriter
    with ExitStack() as stack:
        writer = None
        for part in parts:
            cells = {name: pyarrow.array(column, from_pandas=True) for name, column in part.items()}
            table = pyarrow.table(cells)
            writer = writer or stack.enter_context(make(str(draft), table.schema))
            writer.write_table(table)


def _build_table_columns(found: ChunkedContours, chunk: Chunk) -> dict[str, Array]:
    """Build columns on what the closed contours of a chunk enclose, lengths in the unit of the image if it has one.

    Of contours that reach beyond the next chunk, the area includes what lies inside, and gray levels are not measured.
    """
    source, own = found.task.source, [one for one in found.read_chunk_contours(chunk.number) if one.closed]
    levels = source.levels
    low, high = window_limits(expand_window(chunk.core, found.grid.side, found.grid.shape))
    short: list[Contour] = []
    long: list[Contour] = []
    for one in own:
        (short if (one.box[0] >= low).all() and (one.box[1] <= high).all() else long).append(one)
    numbers = [*_number_labels(short).values(), *_number_labels(long).values()]
    columns: dict[str, list[Array]] = {"label": [np.array(numbers, np.int64)]}
    for some in (short, long):
        labels: NDArray[Any] = np.zeros((1, 1), np.int64)
        contours, gray, count = some, None, len(_number_labels(some))
        if some and some is short:
            window = _find_window_around(found, chunk, some)
            contours = [one for one in _add_inner_contours(found, chunk, some) if one.closed]
            labels, gray = (
                rasterize_labels(_shift_contours(contours, window), window_shape(window)),
                source.read_grays(window),
            )
        table = measure_regions(contours, labels, gray, levels.spacing[1:], levels.unit)
        for name in dict.fromkeys((*table, *_GRAY_COLUMNS)):
            if name not in ("label", "name"):
                values = table[name][:count] if name in table else np.full(count, np.nan)
                columns.setdefault(name_column(name, table.units.get(name, "")), []).append(np.asarray(values, float))
    return {name: np.concatenate(parts) for name, parts in columns.items()}


_GRAY_COLUMNS = ("intensity_mean", "intensity_std", "intensity_min", "intensity_max")


def _wait_for_jobs(results: Iterable[object]) -> None:
    """Wait until all jobs are done."""
    for _ in results:
        pass


WRITERS: Mapping[str, Callable[..., str | None]] = {
    ".zarr": write_label_image,
    ".geojson": write_geojson_tiles,
    **dict.fromkeys((".csv", ".parquet"), write_contour_table),
}
"""Suffixes -> writers."""
