"""``cpm batch``: applies a session file to many images, whose files and table are written as each of them is done."""

from __future__ import annotations

import argparse
import csv
import io
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from cpm_core.cli.arguments import (
    add_images,
    add_max_steps,
    add_parameters,
    add_session,
    parameters_of,
    whole_number,
)
from cpm_core.cli.output import IN_PART, StatusLine, announce_compilation, print_json, say, say_notes
from cpm_core.cli.workers import Done, Job, elsewhere, here
from cpm_core.formats import WRITABLE
from cpm_core.formats.common.atomic import append, interrupts_put_off, write_together
from cpm_core.formats.common.content import fingerprint, fingerprint_if_read
from cpm_core.formats.common.printable import cell, printable, text_of_cell
from cpm_core.formats.common.provenance import VERSION
from cpm_core.formats.sessions.session_file import SessionFile, load_session
from cpm_core.parameters import Parameters
from cpm_core.parameters.quotation import counted, shown
from cpm_core.shapes.document_shapes import starts_of

NAME = "summary.csv"
"""Name of the table in the folder of a batch."""

_LONGEST = 200
"""Longest part of an image's name that is taken into those of its files [bytes]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_images(parser)
    add_session(parser, required=True)
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--workers", metavar="N", type=whole_number(), help="processes to work in, each on one core (default: all)"
    )
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="work on a dask cluster that sees the same files; dask trusts its network, and whoever reaches the "
        "scheduler can run programs on its workers",
    )
    add_parameters(parser.add_argument_group("parameters (in place of those of the session)"))
    outcome = parser.add_argument_group("outcome")
    outcome.add_argument("--output", metavar="DIR", required=True, help="folder to write to; made if there is none")
    outcome.add_argument(
        "--export",
        metavar="SUFFIX",
        nargs="+",
        default=["svg", "csv", "png"],
        help=f"formats to write (default: svg csv png; of {', '.join(WRITABLE)})",
    )
    add_max_steps(outcome)
    outcome.add_argument("--again", action="store_true", help="do also what the summary says is done")


def run(arguments: argparse.Namespace) -> int:
    """Process all images, after all checks that need none of them."""
    source = Path(arguments.session)
    session = load_session(source)
    parameters = parameters_of(arguments, session.parameters)
    suffixes = tuple(dict.fromkeys(f".{suffix.lower().lstrip('.')}" for suffix in arguments.export))
    for suffix in suffixes:
        if suffix not in WRITABLE:
            raise ValueError(f"--export is {shown(suffix)} but must be one of {', '.join(WRITABLE)}.")
    if not starts_of(session.shapes):
        raise ValueError(f"{source} has no start: draw one, or start everywhere, and save it again.")
    output = Path(arguments.output)
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"--output is {output} but no folder can be made there: {error.strerror or error}.") from error
    order = Order(
        arguments.images,
        session,
        fingerprint(source),
        output,
        suffixes,
        parameters,
        arguments.max_steps,
        arguments.again,
    )
    batch = Batch(order)
    say_notes(source.name, session.notes)
    if batch.known:
        say(f"{counted(len(batch.known), 'image')} done before; --again does them again.")
    jobs, began = batch.jobs, time.perf_counter()
    try:
        announce_compilation()
        results = elsewhere(jobs, arguments.scheduler) if arguments.scheduler else here(jobs, arguments.workers)
        with StatusLine() as line:
            for done, (number, row) in enumerate(batch.rows(results), start=1):
                for sentence in filter(None, (row.trouble, *row.notes)):
                    line.say(f"{order.images[number]}: {sentence}")
                line.count(done, len(jobs))
    except KeyboardInterrupt:
        finished = f"{len(batch.summary.rows)} of {counted(len(order.images), 'image')} were done"
        raise KeyboardInterrupt(f"{finished}; the same command does the others") from None
    rows = list(batch.summary.rows.values())
    # an image may be done although a format could not hold what was found
    lacking = sum(not row.trouble and len(row.files) < len(suffixes) for row in rows)
    failed, seconds = sum(bool(row.trouble) for row in rows), time.perf_counter() - began
    if arguments.json:
        images = [_facts(row, output) for row in rows]
        counts = {"done": len(rows) - failed, "failed": failed, "lacking_files": lacking, "seconds": round(seconds, 3)}
        print_json("batch", {"images": images, **counts, "summary": str(output / NAME)})
    else:
        for row in rows:
            if not row.trouble:
                print(f"{printable(row.image)}: {counted(int(str(row.facts['contours'])), 'contour')}")
        more = (f", {failed} failed" if failed else "") + (f", {lacking} without some files" if lacking else "")
        print(printable(f"{counted(len(rows), 'image')} in {seconds:.1f} s{more}; wrote {output / NAME}"))
    return IN_PART if failed or lacking else 0


def _facts(row: Row, output: Path) -> dict[str, Any]:
    files = [str(output / name) for name in row.files]
    return {"image": row.image, **row.facts, "files": files, "trouble": row.trouble, "notes": list(row.notes)}


@dataclass(frozen=True, slots=True)
class Order:
    """What a batch has to do.

    Attributes
    ----------
    images : sequence of str
        The images as they were named.
    session : SessionFile
        Start, regions, charges and review.
    session_sha256 : str
        Hash of the session file.
    output : Path
        The folder that is written to.
    suffixes : tuple of str
        Formats to write.
    parameters : Parameters
        Parameters of the runs.
    max_steps : int or None
        Largest number of steps of a run.
    again : bool
        Whether to do what is done already.
    """

    images: Sequence[str]
    session: SessionFile
    session_sha256: str
    output: Path
    suffixes: tuple[str, ...]
    parameters: Parameters
    max_steps: int | None = None
    again: bool = False

    @property
    def settings(self) -> str:
        """What is asked in addition to the session: other parameters, steps, formats."""
        parts = {field.name: getattr(self.parameters, field.name) for field in fields(Parameters)}
        changed = [
            f"{name}={value}" for name, value in parts.items() if value != getattr(self.session.parameters, name)
        ]
        steps = [] if self.max_steps is None else [f"max_steps={self.max_steps}"]
        return " ".join([*changed, *steps, f"export={','.join(self.suffixes)}"])


class Batch:
    """The images of an order, what has been done with them before, and what is left to do.

    Raises
    ------
    ValueError
        When the table in the folder cannot be read.
    """

    def __init__(self, order: Order) -> None:
        self.order = order
        self.summary = Summary(order.output, order.images)
        known = {} if order.again else self.summary.done(order.session_sha256, order.settings)
        self.known: Mapping[int, Row] = known
        """Rows of the images that are done, by their number."""
        self._stems = _stems(order, known, self.summary.taken())
        self.jobs = tuple(
            Job(number, str(Path(image).absolute()), order.session, order.parameters, order.max_steps, order.suffixes)
            for number, image in enumerate(order.images)
            if number not in known
        )
        """What is left to do."""

    def rows(self, results: Generator[Done]) -> Iterator[tuple[int, Row]]:
        """Write the files and the row of each image as it is done, and yield it; at the end the table is in order."""
        self.summary.write()
        try:
            with closing(results):
                for done in results:
                    with interrupts_put_off():  # files without their row would be made again
                        row = self._written(done)
                        self.summary.add(done.number, row)
                    yield done.number, row
        finally:
            self.summary.write()

    def _written(self, done: Done) -> Row:
        """Write all files of an image, or none, and make a row of the table of it."""
        order, stem = self.order, self._stems[done.number]
        files = [(order.output / f"{stem}{suffix}", content) for suffix, content in done.files.items()]
        error, facts = done.error, done.facts
        try:
            self.summary.release(path.name for path, _ in files)
            write_together(files)
        except ValueError as trouble:
            error, facts, files = str(trouble), {}, []
        return Row(
            order.images[done.number],
            facts,
            tuple(path.name for path, _ in files),
            error,
            done.notes,
            done.sha256,
            order.session_sha256,
            order.settings,
            finished=time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
        )


def _stems(order: Order, known: Mapping[int, Row], taken: set[str]) -> dict[int, str]:
    """Unique file names without a suffix, after the names of the images that are not done yet; none is an image."""
    stems: dict[int, str] = {}
    images = {Path(image).resolve() for image in order.images}

    def is_free(stem: str) -> bool:
        names = [f"{stem}{suffix}" for suffix in order.suffixes]
        return not any(name.lower() in taken or (order.output / name).resolve() in images for name in names)

    for number, image in enumerate(order.images):
        if number not in known:
            short = printable(Path(image).stem).encode()[:_LONGEST].decode(errors="ignore")
            stem = first = f"{short}_contours"
            count = 1
            while not is_free(stem):
                count += 1
                stem = f"{first}_{count}"
            taken |= {f"{stem}{suffix}".lower() for suffix in order.suffixes}
            stems[number] = stem
    return stems


_SEPARATOR = "; "
_LISTS = ("notes", "files")
_FACTS: dict[str, Callable[[str], object]] = {
    **dict.fromkeys(("contours", "closed", "particles", "steps"), int),
    "converged": "True".__eq__,
    "stop_reason": str,
    "seconds": float,
}
"""Values of a run in the table, and how each is read."""

_TEXTS = ("image", "trouble", "image_sha256", "session_sha256", "settings", "version", "finished")
_COLUMNS = ("image", *_FACTS, "trouble", *_LISTS, *_TEXTS[2:])


@dataclass(frozen=True, slots=True)
class Row:
    """What has been done with one image.

    Attributes
    ----------
    image : str
        The image as it was named.
    facts : mapping
        As in ``cpm run --json``; empty when it failed.
    files : tuple of str
        Names of the files that were written, in the folder of the batch.
    trouble : str
        Why it failed, or empty.
    notes : tuple of str
        What was changed on reading, or left out of a file.
    image_sha256, session_sha256 : str
        Hashes of the image and the session file.
    settings : str
        What is asked in addition to the session.
    version : str
        Version of the program.
    finished : str
        When it was finished, in UTC.
    """

    image: str
    facts: dict[str, object] = field(default_factory=dict)
    files: tuple[str, ...] = ()
    trouble: str = ""
    notes: tuple[str, ...] = ()
    image_sha256: str = ""
    session_sha256: str = ""
    settings: str = ""
    version: str = VERSION
    finished: str = ""


class Summary:
    """The table of a folder, with the rows of earlier batches; each new row is appended as soon as it is there.

    Parameters
    ----------
    folder : Path
        Where the files of the batch are.
    images : sequence of str
        The images of this batch, in the order of their rows.

    Raises
    ------
    ValueError
        When there is a table that cannot be read, or is none of a batch.
    """

    def __init__(self, folder: Path, images: Sequence[str]) -> None:
        self._path = folder / NAME
        self._images = images
        self._earlier = _rows(self._path)
        self._rows: dict[int, Row] = {}

    def done(self, session_sha256: str, settings: str) -> dict[int, Row]:
        """Rows of the images that an earlier batch has done in the same way, by their number, and adopts them.

        Session, image, settings and version must be the same, and the files still there.
        """
        names = {Path(row.image).name for row in self._earlier}
        for number, image in enumerate(self._images):
            name = printable(Path(image).name)
            if name not in names:
                continue
            wanted = (name, fingerprint_if_read(Path(image)), session_sha256, settings, VERSION)
            for row in self._earlier:
                known = (Path(row.image).name, row.image_sha256, row.session_sha256, row.settings, row.version)
                there = all((self._path.parent / file).is_file() for file in row.files)
                if not row.trouble and wanted == known and there:
                    self._earlier.remove(row)
                    self._rows[number] = row
                    break
        return dict(self._rows)

    def taken(self) -> set[str]:
        """Names of files, in lower case, that belong to other images than those of this batch, or are done."""
        own = {Path(printable(image)).absolute() for image in self._images}
        others = [row for row in self._earlier if Path(row.image).absolute() not in own]
        return {name.lower() for row in (*others, *self._rows.values()) for name in row.files}

    def release(self, names: Iterable[str]) -> None:
        """Drop earlier rows of files that are about to be replaced."""
        replaced = {name.lower() for name in names}
        kept = [row for row in self._earlier if replaced.isdisjoint(name.lower() for name in row.files)]
        if len(kept) < len(self._earlier):
            self._earlier = kept
            self.write()

    def add(self, number: int, row: Row) -> None:
        """Add the row of an image to the table, which has been written before."""
        self._rows[number] = row
        append(self._path, _lines([row]))

    def write(self) -> None:
        """Write the whole table: the rows of this batch in its order, and earlier ones of other images."""
        own = {printable(self._images[number]) for number in self._rows}
        rows = [row for row in self._earlier if row.image not in own]
        header = f"{','.join(_COLUMNS)}\n".encode()
        write_together([(self._path, header + _lines([*rows, *self.rows.values()]))])

    @property
    def rows(self) -> dict[int, Row]:
        """Rows of this batch, by the number of the image."""
        return dict(sorted(self._rows.items()))


def _rows(path: Path) -> list[Row]:
    """Rows of a table; none where there is no table yet."""
    try:
        content = path.read_bytes()
        text = content[: content.rfind(b"\n") + 1].decode()  # a row that was cut short is that of an image not done
    except FileNotFoundError:
        return []
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror or error}.") from error
    except UnicodeDecodeError:
        raise ValueError(f"{path} is damaged: remove it, or choose another folder.") from None
    lines = list(csv.DictReader(io.StringIO(text, newline="")))
    if lines and "image" not in lines[0]:
        raise ValueError(f"{path} is not the table of a batch, and would be replaced: choose another folder.")
    try:
        return [_row({name: text_of_cell(line.get(name) or "") for name in _COLUMNS}) for line in lines]
    except ValueError:
        raise ValueError(f"{path} is damaged: remove it, or choose another folder.") from None


def _row(line: Mapping[str, str]) -> Row:
    facts = {name: read(line[name]) for name, read in _FACTS.items() if line[name]}
    notes, files = (tuple(filter(None, line[name].split(_SEPARATOR))) for name in _LISTS)
    return Row(facts=facts, files=files, notes=notes, **{name: line[name] for name in _TEXTS})


def _lines(rows: Iterable[Row]) -> bytes:
    text = io.StringIO()
    table = csv.DictWriter(text, _COLUMNS, restval="", lineterminator="\n")
    for row in rows:
        lists = {name: _SEPARATOR.join(getattr(row, name)) for name in _LISTS}
        line = {**{name: getattr(row, name) for name in _TEXTS}, **lists, **row.facts}
        table.writerow({name: cell(value) if isinstance(value, str) else value for name, value in line.items()})
    return text.getvalue().encode()
