"""``cpm batch``: applies a session file to many images."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from cpm_core.cli.arguments import add_json, add_parameters, add_session, as_steps, parameters_of
from cpm_core.cli.batch.batch import Batch, Order
from cpm_core.cli.batch.summary import NAME, Row
from cpm_core.cli.batch.workers import elsewhere, here
from cpm_core.cli.inputs import as_number
from cpm_core.cli.outcome import IN_PART, print_json
from cpm_core.cli.terminal import Count, announce_compilation
from cpm_core.formats import READABLE, WRITABLE
from cpm_core.formats.common.content import fingerprint
from cpm_core.formats.common.printable import printable
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.parameters.quotation import counted, shown
from cpm_core.shapes.document_shapes import starts_of

_STANDARD = (".svg", ".csv", ".png")


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("batch", help="find the contours of many images", allow_abbrev=False)
    parser.set_defaults(command=_batch)
    parser.description = (
        "Apply a session file to each image: its start, regions, charges and parameters, and of a file of several "
        "images the page, channel, point in time and series that the session shows. An image that fails is "
        "reported, and the others go on. What the summary in the folder says is done already is not done again."
    )
    parser.add_argument(
        "images", metavar="IMAGE", nargs="+", help=f"image, folder or pattern such as *.tif ({', '.join(READABLE)})"
    )
    add_session(parser, required=True)
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--workers", metavar="N", type=as_number, help="processes to work in, each on one core (default: one a core)"
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
        default=list(_STANDARD),
        help=f"formats to write (default: svg csv png; of {', '.join(WRITABLE)})",
    )
    outcome.add_argument("--max-steps", metavar="N", type=as_number, help="stop each run after so many steps at most")
    outcome.add_argument("--again", action="store_true", help="do also what the summary says is done")
    add_json(outcome)


def _batch(arguments: argparse.Namespace) -> int:
    """Process all images, after all checks that need none of them."""
    session = load_session(Path(arguments.session))
    parameters = parameters_of(arguments, session.parameters)
    max_steps, workers = as_steps(arguments.max_steps), _workers(arguments.workers)
    suffixes = _suffixes(arguments.export)
    if not starts_of(session.shapes):
        raise ValueError(f"{arguments.session} has no start: draw one, or start everywhere, and save it again.")
    fingerprinted = fingerprint(Path(arguments.session))
    order = Order(
        arguments.images,
        session,
        fingerprinted,
        _folder(arguments.output),
        suffixes,
        parameters,
        max_steps,
        arguments.again,
    )
    batch = Batch(order)
    for note in session.notes:
        print(f"cpm: {note}", file=sys.stderr)
    if batch.known:
        print(f"cpm: {counted(len(batch.known), 'image')} done before; --again does them again.", file=sys.stderr)
    jobs, images = batch.jobs, counted(len(order.images), "image")
    try:
        announce_compilation()
        results = elsewhere(jobs, arguments.scheduler) if arguments.scheduler else here(jobs, workers)
        began = time.perf_counter()
        with Count(len(jobs)) as progress:
            for number, row in batch.rows(results):
                progress.advance()
                for sentence in filter(None, (row.trouble, *row.notes)):
                    progress.message(printable(f"cpm: {order.images[number]}: {sentence}"))
        rows = list(batch.summary.rows.values())
        _report(rows, order, time.perf_counter() - began, as_json=arguments.json)
    except KeyboardInterrupt:
        finished = f"{len(batch.summary.rows)} of {images} were done, and their files are complete"
        raise KeyboardInterrupt(f"{finished}; the same command does the others") from None
    return IN_PART if any(row.trouble or _lacks_files(row, order) for row in rows) else 0


def _workers(given: int | float | str | None) -> int | None:
    if given is None or (isinstance(given, int) and 0 < given <= 1024):
        return given
    raise ValueError(f"--workers is {given} but must be a whole number from 1 to 1024.")


def _suffixes(given: Sequence[str]) -> tuple[str, ...]:
    """Suffixes with their dot, without repeats."""
    wanted = tuple(dict.fromkeys(f".{suffix.lower().lstrip('.')}" for suffix in given))
    for suffix in wanted:
        if suffix not in WRITABLE:
            raise ValueError(f"--export is {shown(suffix)} but must be one of {', '.join(WRITABLE)}.")
    return wanted


def _folder(given: str) -> Path:
    folder = Path(given)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"--output is {folder} but no folder can be made there: {error.strerror or error}.") from error
    return folder


def _lacks_files(row: Row, order: Order) -> bool:
    """Whether an image was done, but a format could not hold what was found; its notes say why."""
    return not row.trouble and len(row.files) < len(order.suffixes)


def _report(every: Sequence[Row], order: Order, seconds: float, *, as_json: bool) -> None:
    failed, lacking = sum(bool(row.trouble) for row in every), sum(_lacks_files(row, order) for row in every)
    output = order.output
    if as_json:
        images = [
            {
                "image": row.image,
                **row.facts,
                "files": [str(output / name) for name in row.files],
                "trouble": row.trouble,
                "notes": list(row.notes),
            }
            for row in every
        ]
        facts = {"images": images, "done": len(every) - failed, "failed": failed}
        facts |= {"lacking_files": lacking, "seconds": round(seconds, 3)}
        print_json("batch", {**facts, "summary": str(output / NAME)})
        return
    for row in every:
        if not row.trouble:
            print(f"{printable(row.image)}: {counted(int(str(row.facts['contours'])), 'contour')}")
    failures = f", {failed} failed" if failed else ""
    failures += f", {lacking} without some files" if lacking else ""
    print(printable(f"{counted(len(every), 'image')} in {seconds:.1f} s{failures}; wrote {output / NAME}"))
