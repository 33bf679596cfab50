"""``cpm batch``: applies a session file to many images."""

from __future__ import annotations

import argparse
import csv
import io
import json
import sys
import time
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from cpm_core.cli.arguments import add_json, add_parameters, add_session, as_number, as_steps, parameters_of
from cpm_core.cli.jobs import Done, Job
from cpm_core.cli.terminal import Count, counted
from cpm_core.cli.workers import elsewhere, here
from cpm_core.formats import READABLE, WRITABLE
from cpm_core.formats.atomic import write_together
from cpm_core.formats.sessions.session_file import load_session
from cpm_core.shapes.document_shapes import starts_of

SUMMARY = "summary.csv"
"""The table of all images."""

FAILED = 1
"""Exit status when some images failed."""

_STANDARD = (".svg", ".csv", ".png")
_COLUMNS = ("image", "contours", "closed", "particles", "steps", "converged", "stop_reason", "seconds", "trouble")


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("batch", help="find the contours of many images", allow_abbrev=False)
    parser.set_defaults(command=_batch)
    parser.description = (
        "Apply a session file to each image: its start, regions, charges and parameters. An image that fails is "
        "reported, and the others go on."
    )
    parser.add_argument("images", metavar="IMAGE", nargs="+", help=f"image file ({', '.join(READABLE)})")
    add_session(parser, required=True)
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", metavar="N", type=as_number, help="processes to work in (default: one a core)")
    where.add_argument("--scheduler", metavar="ADDRESS", help="work on a dask cluster that sees the same files")
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
    add_json(outcome)


@dataclass(frozen=True, slots=True)
class _Written:
    """An image with its result and the files that were written for it."""

    image: str
    done: Done
    files: tuple[str, ...]


def _batch(arguments: argparse.Namespace) -> int:
    """Process all images, after all checks that need none of them."""
    session = load_session(Path(arguments.session))
    parameters = parameters_of(arguments, session.parameters)
    max_steps, workers = as_steps(arguments.max_steps), _workers(arguments.workers)
    suffixes = _suffixes(arguments.export)
    if not starts_of(session.shapes):
        raise ValueError(f"{arguments.session} has no start: draw one, or start everywhere, and save it again.")
    output = _folder(arguments.output)
    stems = _stems(arguments.images)
    for note in session.notes:
        print(f"cpm: {note}", file=sys.stderr)
    paths = [str(Path(image).absolute()) for image in arguments.images]
    jobs = [Job(number, path, session, parameters, max_steps, suffixes) for number, path in enumerate(paths)]
    results = elsewhere(jobs, arguments.scheduler) if arguments.scheduler else here(jobs, workers)
    began, progress = time.perf_counter(), Count(len(jobs))
    written: dict[int, _Written] = {}
    try:
        with closing(results), progress:
            for done in results:
                image = arguments.images[done.number]
                one = _write(image, done, output, stems[done.number])
                written[done.number] = one
                progress.advance()
                if one.done.error:
                    progress.message(f"cpm: {image}: {one.done.error}")
    except KeyboardInterrupt:
        so_far = f"{len(written)} of {counted(len(jobs), 'image')} were done, and their files are complete"
        raise KeyboardInterrupt(so_far) from None
    every = [written[number] for number in sorted(written)]
    write_together([(output / SUMMARY, _summary(every))])
    _report(every, output, time.perf_counter() - began, as_json=arguments.json)
    return FAILED if any(one.done.error for one in every) else 0


def _write(image: str, done: Done, output: Path, stem: str) -> _Written:
    """Write all files of an image, or none."""
    files = [(output / f"{stem}{suffix}", content) for suffix, content in done.files.items()]
    try:
        write_together(files)
    except ValueError as error:
        return _Written(image, Done(done.number, error=str(error)), ())
    return _Written(image, done, tuple(str(path) for path, _ in files))


def _workers(given: int | float | str | None) -> int | None:
    if given is None or (isinstance(given, int) and 0 < given <= 1024):
        return given
    raise ValueError(f"--workers is {given} but must be a whole number from 1 to 1024.")


def _suffixes(given: Sequence[str]) -> tuple[str, ...]:
    """Suffixes with their dot, without repeats."""
    wanted = tuple(dict.fromkeys(f".{suffix.lower().lstrip('.')}" for suffix in given))
    for suffix in wanted:
        if suffix not in WRITABLE:
            raise ValueError(f'--export is "{suffix}" but must be one of {", ".join(WRITABLE)}.')
    return wanted


def _folder(given: str) -> Path:
    folder = Path(given)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(f"--output is {folder} but no folder can be made there: {error.strerror or error}.") from error
    return folder


def _stems(images: Sequence[str]) -> list[str]:
    """Unique file names without a suffix, after the names of the images."""
    stems: list[str] = []
    taken: set[str] = set()
    for image in images:
        stem = first = f"{Path(image).stem}_contours"
        number = 1
        while stem.lower() in taken:
            number += 1
            stem = f"{first}_{number}"
        taken.add(stem.lower())
        stems.append(stem)
    return stems


def _summary(every: Sequence[_Written]) -> bytes:
    text = io.StringIO()
    table = csv.DictWriter(text, _COLUMNS, restval="", lineterminator="\n")
    table.writeheader()
    table.writerows({"image": one.image, "trouble": one.done.error, **one.done.facts} for one in every)
    return text.getvalue().encode("utf-8", "surrogateescape")


def _report(every: Sequence[_Written], output: Path, seconds: float, *, as_json: bool) -> None:
    failed = sum(bool(one.done.error) for one in every)
    if as_json:
        images = [
            {"image": one.image, **one.done.facts, "files": list(one.files), "trouble": one.done.error} for one in every
        ]
        facts = {"images": images, "done": len(every) - failed, "failed": failed, "seconds": round(seconds, 3)}
        print(json.dumps({**facts, "summary": str(output / SUMMARY)}))
        return
    for one in every:
        if not one.done.error:
            print(f"{one.image}: {counted(int(str(one.done.facts['contours'])), 'contour')}")
    failures = f", {failed} failed" if failed else ""
    print(f"{counted(len(every), 'image')} in {seconds:.1f} s{failures}; wrote {output / SUMMARY}")
