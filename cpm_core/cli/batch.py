"""``cpm batch``: finds the objects of many images by a session; the files of each are written as soon as it is done."""

from __future__ import annotations

import argparse
import csv
import io
import itertools
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, replace
from operator import attrgetter
from pathlib import Path

from cpm_core.cli.arguments import add_options, add_parameter_options, parse_parameters
from cpm_core.cli.output import EXIT_IN_PART, StatusLine, ensure_compiled, print_json, print_note, print_notes
from cpm_core.cli.workers import BatchJob, BatchKind, BatchRow, NamedFiles, run_locally, run_on_scheduler
from cpm_core.formats import (
    CONTOURS_WRITABLE,
    FORMATS_BY_NAME,
    VOLUMES_WRITABLE,
    choose_file_name,
    find_format,
    find_named_suffix,
)
from cpm_core.formats.common.atomic import append_bytes, draft_files, remove_abandoned_drafts, write_together
from cpm_core.formats.common.content import compute_fingerprint, find_local_file, try_fingerprint
from cpm_core.formats.common.printable import escape_cell, make_printable, unescape_cell
from cpm_core.formats.sessions.session_file import SessionFile, load_session
from cpm_core.formats.sessions.session_run import is_volume_session
from cpm_core.numerics.types import JsonDict, Texts
from cpm_core.parameters import Parameters
from cpm_core.parameters.formatting import format_choice, format_count, quote_value
from cpm_core.shapes.document_shapes import select_starts

SUMMARY_NAME = "summary.csv"
"""Name of the table of images in the folder of a batch."""

_TABLE_SUFFIXES: dict[BatchKind, str] = {"objects": ".table.csv", "contours": ".measures.csv"}
"""Suffixes of the tables of the images, which are joined in one."""

_JOINED_NAMES: dict[BatchKind, str] = {"objects": "objects.csv", "contours": "measures.csv"}
"""Name of that table in the folder of a batch."""

_PLANE_SUFFIXES = (".svg", ".png")
"""Formats that are written by default beside the table of an image."""

_VOLUME_SUFFIXES = (".tif",)
"""Formats that are written by default beside the table of a volume."""

_MAX_STEM_BYTES = 200
"""Longest part of an image's name that the names of its files begin with [bytes]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_options(parser, "images")
    add_options(parser, "--session", required=True)
    add_options(parser.add_mutually_exclusive_group(), "--workers", "--scheduler")
    add_parameter_options(parser.add_argument_group("parameters", "In place of those of the session."))
    outcome = parser.add_argument_group("outcome")
    outcome.add_argument("--output", metavar="DIR", required=True, help="Folder to write to; made if there is none.")
    outcome.add_argument(
        "--export",
        metavar="FORMAT",
        nargs="+",
        help=f"Formats to write: {', '.join(FORMATS_BY_NAME)}, or a suffix (default: csv, svg and png; in volumes csv "
        f"and tif). Suffixes: {', '.join(dict.fromkeys((*CONTOURS_WRITABLE, *VOLUMES_WRITABLE)))}.",
    )
    outcome.add_argument(
        "--contours",
        dest="kind",
        action="store_const",
        const="contours",
        default="objects",
        help="Write the contours instead of the objects.",
    )
    add_options(outcome, "--max-steps")
    outcome.add_argument("--again", action="store_true", help="Do also what the summary says is done.")
    outcome.add_argument(
        "--dry-run", action="store_true", help="Write nothing; list what would be read, written and overwritten."
    )


def run_batch(arguments: argparse.Namespace) -> int:
    """Process all images, after all checks that need none of them."""
    source = Path(arguments.session)
    session = load_session(source)
    parameters = parse_parameters(arguments, session.parameters)
    in_volume = is_volume_session(session)
    writable = VOLUMES_WRITABLE if in_volume else CONTOURS_WRITABLE
    default = (*(_VOLUME_SUFFIXES if in_volume else _PLANE_SUFFIXES), _TABLE_SUFFIXES[arguments.kind])
    suffixes = tuple(dict.fromkeys(map(find_named_suffix, arguments.export or default)))
    for suffix in suffixes:
        if suffix not in writable:
            choice = format_choice(suffix, (*FORMATS_BY_NAME, *writable))
            raise ValueError(f"--export is {quote_value(suffix)} but must be {choice}")
        find_format(suffix)
    if not select_starts(session.shapes):
        raise ValueError(f"{source} has no start: draw one, or start everywhere, and save it again.")
    output = Path(arguments.output)
    if not arguments.dry_run:
        _make_folder(output)
    batch = Batch(
        arguments.images,
        session,
        source,
        output,
        suffixes,
        parameters,
        arguments.max_steps,
        kind=arguments.kind,
        again=arguments.again,
    )
    if arguments.dry_run:
        return _list_plan(batch, arguments)
    print_notes(source.name, session.notes)
    if batch.rows:
        print_note(f"{format_count(len(batch.rows), 'image')} done before; --again does them again.")
    jobs, began = batch.jobs, time.perf_counter()
    try:
        ensure_compiled()
        results = (
            run_on_scheduler(jobs, arguments.scheduler) if arguments.scheduler else run_locally(jobs, arguments.workers)
        )
        with StatusLine() as line:
            for done, row in enumerate(batch.write_results(results), start=1):
                for sentence in filter(None, (row.trouble, *row.notes)):
                    line.print_above(f"{row.image}: {sentence}")
                line.show_count(done, len(jobs))
    except KeyboardInterrupt:
        finished = f"{len(batch.rows)} of {format_count(len(arguments.images), 'image')} were done"
        raise KeyboardInterrupt(f"{finished}; the same command does the others") from None
    rows = batch.rows.values()
    # an image may be done although a format could not hold what was found
    lacking = sum(bool(not row.trouble and row.found and len(row.files) < len(suffixes)) for row in rows)
    failed, seconds = sum(bool(row.trouble) for row in rows), time.perf_counter() - began
    if arguments.json:
        images = [
            {"image": row.image, **row.facts, "files": [str(output / name) for name in row.files],
             "trouble": row.trouble, "notes": list(row.notes)}
            for row in rows
        ]  # fmt: skip
        counts = {"done": len(rows) - failed, "failed": failed, "lacking_files": lacking, "seconds": round(seconds, 3)}
        print_json(arguments.name, {"images": images, **counts, "summary": str(output / SUMMARY_NAME)})
    else:
        for row in rows:
            if not row.trouble:
                likely = f", {row.facts['likely']} likely" if "likely" in row.facts else ""
                print(f"{make_printable(row.image)}: {format_count(row.found, arguments.kind[:-1])}{likely}")
        more = (f", {failed} failed" if failed else "") + (f", {lacking} without some files" if lacking else "")
        tables = " and ".join(str(output / name) for name in batch.table_names)
        print(make_printable(f"{format_count(len(rows), 'image')} in {seconds:.1f} s{more}; wrote {tables}"))
    return EXIT_IN_PART if failed or lacking else 0


def _make_folder(output: Path) -> None:
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"--output is {output} but no folder can be made there: {error.strerror or error}.") from error


def _list_plan(batch: Batch, arguments: argparse.Namespace) -> int:
    """List what a batch would read, write and overwrite."""
    images = [
        {
            "image": job.row.image,
            "writes": [str(file) for file, _ in job.files],
            "overwrites": [str(file) for file, _ in job.files if file.exists()],
        }
        for job in batch.jobs
    ]
    if arguments.json:
        print_json(arguments.name, {"plan": images, "done_before": len(batch.rows)})
        return 0
    for job in batch.jobs:
        files = ", ".join(f"{file.name}{' (exists)' if file.exists() else ''}" for file, _ in job.files)
        print(make_printable(f"{job.row.image}: {files}"))
    tables = " and ".join(batch.table_names)
    before = f", {len(batch.rows)} done before" if batch.rows else ""
    count = format_count(len(images), "image")
    print(make_printable(f"{count} to do{before}; would write these files, {tables} in {arguments.output}"))
    return 0


class Batch:
    """A session for many images, and the table in their folder, which keeps the rows of earlier batches.

    Parameters
    ----------
    images : sequence of str
        The images as the user named them: paths, or addresses of fsspec.
    session : SessionFile
        Start, regions and charges.
    source : Path
        The file of the session.
    output : Path
        The folder that is written to.
    suffixes : tuple of str
        Formats to write.
    parameters : Parameters, optional
        Parameters of the runs; those of the session by default.
    max_steps : int, optional
        Largest number of steps of a run.
    kind : {"objects", "contours"}
        What is written of each image.
    again : bool
        Whether to repeat what is done already: the same image by the same session, settings and version.

    Attributes
    ----------
    rows : dict of BatchRow
        Outcomes, by the index of the image.
    jobs : tuple of BatchJob
        Images that were left to do at the beginning.

    Raises
    ------
    ValueError
        When the table in the folder cannot be read.
    """

    def __init__(
        self,
        images: Sequence[str],
        session: SessionFile,
        source: Path,
        output: Path,
        suffixes: Texts,
        parameters: Parameters | None = None,
        max_steps: int | None = None,
        *,
        kind: BatchKind = "objects",
        again: bool = False,
    ) -> None:
        parameters = parameters or session.parameters
        usual = asdict(session.parameters)
        asked = [f"{name}={value}" for name, value in asdict(parameters).items() if value != usual[name]]
        asked += [] if max_steps is None else [f"max_steps={max_steps}"]
        plain = BatchRow(
            "", session_sha256=compute_fingerprint(source), settings=" ".join([*asked, f"{kind}={','.join(suffixes)}"])
        )
        self._images, self._folder, self._suffixes, self._kind = images, output, suffixes, kind
        self._paths = tuple(map(find_local_file, images))
        known = _read_rows(output / SUMMARY_NAME)
        self.rows: dict[int, BatchRow] = {} if again else dict(self._find_done_rows(known, plain))
        own, used = {Path(make_printable(image)).absolute() for image in images}, set(map(id, self.rows.values()))
        # the files of images of this batch will be replaced, and no row may outlive its files if the batch is killed
        self._others = [row for row in known if id(row) not in used and Path(row.image).absolute() not in own]
        self.jobs = tuple(
            BatchJob(number, replace(plain, image=images[number]), str(self._paths[number].absolute()), session,
                parameters, max_steps, files, kind)
            for number, files in self._name_files()
        )  # fmt: skip

    @property
    def table_names(self) -> Texts:
        """Names of the tables that join what all images have."""
        joined = _TABLE_SUFFIXES[self._kind] in self._suffixes
        return (SUMMARY_NAME, *([_JOINED_NAMES[self._kind]] if joined else []))

    def _find_done_rows(self, known: Iterable[BatchRow], plain: BatchRow) -> Iterator[tuple[int, BatchRow]]:
        """Find the images that an earlier batch did in the same way and whose files still exist, with their rows."""
        way = attrgetter("session_sha256", "settings", "version", "trouble")
        alike: dict[tuple[str, str], list[BatchRow]] = {}
        for row in known:
            if way(row) == way(plain) and all((self._folder / file).is_file() for file in row.files):
                alike.setdefault((Path(row.image).name, row.image_sha256), []).append(row)
        names = {name for name, _ in alike}
        for number, image in enumerate(self._images):
            name = make_printable(Path(image).name)
            if name in names and (rows := alike.get((name, try_fingerprint(self._paths[number])))):
                yield number, rows.pop(0)

    def _name_files(self) -> Iterator[tuple[int, NamedFiles]]:
        """Name the files of each image that is left to do; none belongs to another image, or is an input."""
        folder = self._folder.resolve()
        known = [folder / name for row in self._list_table_rows() for name in row.files]
        taken = {str(file).lower() for file in (*known, *(path.resolve() for path in self._paths))}
        tried: dict[str, int] = {}
        for number in (number for number in range(len(self._images)) if number not in self.rows):
            start = make_printable(self._paths[number].stem).encode()[:_MAX_STEM_BYTES].decode(errors="ignore")
            for count in itertools.count(tried.get(start, 1)):
                stem = start if count == 1 else f"{start}_{count}"
                files = tuple(
                    (folder / choose_file_name(stem, self._kind, suffix), suffix) for suffix in self._suffixes
                )
                names = {str(file).lower() for file, _ in files}
                if taken.isdisjoint(names):
                    break
            tried[start] = count
            taken |= names
            yield number, files

    def write_results(self, results: Generator[tuple[BatchJob, BatchRow]]) -> Iterator[BatchRow]:
        """Write the row of each image as it is done, and yield the row; finally sort the table."""
        remove_abandoned_drafts(self._folder)
        self._write_table()
        try:
            with closing(results):
                for job, found in results:
                    finished = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
                    row = self.rows[job.number] = replace(found, finished=finished)
                    append_bytes(self._folder / SUMMARY_NAME, _format_rows([row]))
                    yield row
        finally:
            self.rows = dict(sorted(self.rows.items()))
            self._write_table()
        for name in self.table_names[1:]:
            self._join_tables(name)

    def _list_table_rows(self) -> list[BatchRow]:
        """Return the rows of this batch, after earlier ones of other images."""
        return [*self._others, *self.rows.values()]

    def _write_table(self) -> None:
        write_together(
            [
                (
                    self._folder / SUMMARY_NAME,
                    f"{','.join(_SUMMARY_COLUMNS)}\n".encode() + _format_rows(self._list_table_rows()),
                )
            ]
        )

    def _join_tables(self, joined_name: str) -> None:
        """Join the tables of all images, one file at a time, with the image as the first column."""
        files = [
            self._folder / name
            for row in self._list_table_rows()
            for name in row.files
            if name.endswith(choose_file_name("", self._kind, _TABLE_SUFFIXES[self._kind]))
        ]
        with (
            draft_files(self._folder / joined_name) as (draft,),
            draft.open("w", encoding="utf-8", newline="") as stream,
        ):
            heads = set()
            for file in files:
                with file.open(encoding="utf-8", newline="") as table:
                    heads.add(tuple(next(csv.reader(table))))
            longest_first = sorted(heads, key=len, reverse=True)
            columns = dict.fromkeys(["image", *itertools.chain.from_iterable(longest_first)])
            joined = csv.DictWriter(stream, columns, restval="", lineterminator="\n")
            joined.writeheader()
            for file in files:
                with file.open(encoding="utf-8", newline="") as table:
                    joined.writerows(csv.DictReader(table))


_LIST_SEPARATOR = "; "
"""Separator of the items of a cell."""

_LIST_COLUMNS = ("notes", "files")
"""Columns whose cells hold several items."""

_FACT_COLUMNS: dict[str, Callable[[str], object]] = {
    **dict.fromkeys(("objects", "likely", "contours", "closed", "particles", "steps"), int),
    "converged": "True".__eq__,
    "stop_reason": str,
    "seconds": float,
}
"""Values of a run in the table, and the function that parses each."""

_TEXT_COLUMNS = ("image", "trouble", "image_sha256", "session_sha256", "settings", "version", "finished")
"""Columns of text."""

_SUMMARY_COLUMNS = ("image", *_FACT_COLUMNS, "trouble", *_LIST_COLUMNS, *_TEXT_COLUMNS[2:])
"""All columns, in their order."""


def _read_rows(path: Path) -> list[BatchRow]:
    """Read the rows of a table; none where there is no table yet."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return []
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror or error}.") from error
    try:  # a truncated row belongs to an image that was not finished
        text = content[: content.rfind(b"\n") + 1].decode()
        lines = list(csv.DictReader(io.StringIO(text, newline="")))
        rows = [_parse_row({name: unescape_cell(line.get(name) or "") for name in _SUMMARY_COLUMNS}) for line in lines]
    except ValueError:
        raise ValueError(f"{path} is damaged: remove it, or choose another folder.") from None
    if lines and "image" not in lines[0]:
        raise ValueError(f"{path} is not the table of a batch, and would be replaced: choose another folder.")
    return rows


def _parse_row(line: Mapping[str, str]) -> BatchRow:
    values: JsonDict = {name: line[name] for name in _TEXT_COLUMNS}
    values |= {name: tuple(filter(None, line[name].split(_LIST_SEPARATOR))) for name in _LIST_COLUMNS}
    return BatchRow(facts={name: read(line[name]) for name, read in _FACT_COLUMNS.items() if line[name]}, **values)


def _format_rows(rows: Iterable[BatchRow]) -> bytes:
    text = io.StringIO()
    table = csv.DictWriter(text, _SUMMARY_COLUMNS, restval="", lineterminator="\n")
    for row in rows:
        lists = {name: _LIST_SEPARATOR.join(getattr(row, name)) for name in _LIST_COLUMNS}
        line = {**{name: getattr(row, name) for name in _TEXT_COLUMNS}, **lists, **row.facts}
        table.writerow({name: escape_cell(value) if isinstance(value, str) else value for name, value in line.items()})
    return text.getvalue().encode()
