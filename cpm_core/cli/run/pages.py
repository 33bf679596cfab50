"""``cpm run STACK --pages``: finds the contours on each page of a stack, and follows objects from page to page."""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

from cpm_core.cli.arguments import notes_on
from cpm_core.cli.inputs import check_kept
from cpm_core.cli.outcome import IN_PART, Files, outcome_of, print_json
from cpm_core.cli.terminal import Count, announce_compilation, say
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.formats import load_pages
from cpm_core.formats.common.content import differ
from cpm_core.formats.common.printable import printable
from cpm_core.formats.contours.pages.files import check_stack_export, export_stack, stack_suffix_of
from cpm_core.formats.contours.pages.stack_json import load_stack_result
from cpm_core.formats.images.stack import Pages
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics.types import Array
from cpm_core.pages.follow import follow
from cpm_core.pages.page import Page, StackResult
from cpm_core.parameters import Parameters
from cpm_core.parameters.quotation import counted, shown

_NOT_OF_PAGES = ("page", "object", "close", "truth")
"""Options that have a meaning for one image only; ``--not`` follows ``--object``."""

_SAVED_EVERY = 30.0
"""Least time between two writings of the pages that are done, so that little is lost when the program is killed [s]."""


@dataclass(frozen=True, eq=False)
class StackRun:
    """What is asked of a stack.

    Attributes
    ----------
    path : Path
        The stack.
    part : mapping
        What `load_pages` is told beside the path.
    parameters : Parameters
        Parameters of all runs.
    seeds : callable
        Gives the start on an image.
    drawn : sequence of mapping
        What was drawn, as session files hold it.
    max_steps : int or None
        Greatest number of steps of each run.
    regions, charges
        Limits and placed charges on every page.
    """

    path: Path
    part: Mapping[str, Any]
    parameters: Parameters
    seeds: Callable[[Image], Array]
    drawn: Sequence[Mapping[str, Any]] = ()
    max_steps: int | None = None
    regions: AnyRegions | None = None
    charges: Sequence[PlacedCharge] = ()


def add_pages(parser: argparse._ActionsContainer) -> None:
    """Add which pages are run, as `pages`, `follow` and `resume`."""
    parser.add_argument(
        "--pages",
        metavar="all|N-M,...",
        help="run each of these pages of a stack as an image of its own, in this order",
    )
    parser.add_argument(
        "--follow", action="store_true", help="start each page from the contours of the one before, not from the start"
    )
    parser.add_argument(
        "--resume", action="store_true", help="do not run the pages again that the .json file of --export holds already"
    )


def check_pages(arguments: argparse.Namespace, image: str) -> None:
    """Raise ValueError for options that do not belong together, and for files that cannot be written."""
    for name in ("follow", "resume"):
        if arguments.pages is None and getattr(arguments, name):
            raise ValueError(f"--{name} is for the pages of a stack: add --pages all, or leave it out.")
    if arguments.pages is None:
        return
    for name in _NOT_OF_PAGES:
        if getattr(arguments, name):
            raise ValueError(f"--{name} is for one image, but --pages runs several: leave one of them out.")
    for path in arguments.export:
        check_stack_export(path)
    check_kept(arguments.export, arguments, image)
    if arguments.resume and not _kept_in(arguments.export):
        raise ValueError("--resume needs the .json file that holds the pages that are done: add it to --export.")


def run_pages(arguments: argparse.Namespace, order: StackRun) -> int:
    """Run the pages, and write what is found on all of them; what is done is written on Ctrl+C too."""
    pages = load_pages(order.path, **order.part)
    numbers = numbers_of(arguments.pages, len(pages), pages.name)
    known = _known(arguments, order, pages, numbers)
    _tell_notes(pages, numbers[0], order.parameters)
    announce_compilation()
    found = list(known)
    left = numbers[len(known) :]
    began, saved = time.perf_counter(), time.monotonic()
    runs = follow(
        pages,
        order.seeds,
        order.parameters,
        numbers=left,
        fresh=not arguments.follow,
        max_steps=order.max_steps,
        regions=order.regions,
        charges=order.charges,
        known=known,
    )
    try:
        with Count(len(left)) as count:
            for page in runs:
                found.append(page)
                count.advance()
                if page.trouble:
                    count.message(printable(f"cpm: page {page.number}: {page.trouble}"))
                if time.monotonic() - saved > _SAVED_EVERY:
                    saved = time.monotonic()
                    export_stack(_whole(pages, order, found), *_kept_in(arguments.export))
    except KeyboardInterrupt:
        raise KeyboardInterrupt(_kept(pages, order, found, len(numbers), arguments.export)) from None
    whole = _whole(pages, order, found)
    if not whole.results:
        raise ValueError(f"No page of {pages.name} could be used. Page {found[0].number}: {found[0].trouble}")
    files = Files()
    with files.writing(*arguments.export):
        export_stack(whole, *arguments.export, refused=files.refuse)
    files.check()
    _report(whole, files, time.perf_counter() - began, as_json=arguments.json)
    return files.status() or (IN_PART if len(whole.results) < len(found) else 0)


def numbers_of(given: str, count: int, name: str) -> list[int]:
    """Numbers of pages as they are given: all, or numbers and ranges between commas; ValueError for other text."""
    if given == "all":
        return list(range(1, count + 1))
    numbers: list[int] = []
    for part in given.replace(" ", "").split(","):
        ends = re.fullmatch(r"([0-9]{1,9})(?:-([0-9]{1,9}))?", part)
        if ends is None:
            raise ValueError(f"--pages is {shown(given)} but must be all, or numbers and ranges such as 1,3,5-9.")
        first, last = int(ends[1]), int(ends[2] or ends[1])
        outside = next((page for page in (first, last) if not 1 <= page <= count), None)
        if outside is not None:
            raise ValueError(f"--pages names page {outside}, but {name} has {counted(count, 'page')}.")
        numbers += range(first, last + 1) if first <= last else range(first, last - 1, -1)
    if len(set(numbers)) < len(numbers):
        raise ValueError(f"--pages is {shown(given)} but names a page twice: name each once.")
    return numbers


def _kept_in(exports: Sequence[str]) -> list[str]:
    """The files that hold all that is needed to go on."""
    return [path for path in exports if stack_suffix_of(path) == ".json"]


def _known(arguments: argparse.Namespace, order: StackRun, pages: Pages, numbers: Sequence[int]) -> tuple[Page, ...]:
    """The pages that an earlier run has done, as far as they are the first of those that are wanted."""
    if not arguments.resume:
        return ()
    (path, *_) = _kept_in(arguments.export)
    if not Path(path).exists():
        say(f"cpm: {path} does not exist yet: all pages are run.")
        return ()
    earlier = load_stack_result(Path(path))
    for _, result in earlier.results:
        made = result.provenance
        wanted = {name: getattr(order.parameters, name) for name in made.parameters if name != "scales"}
        if differ(made.sha256, pages.sha256) or any(made.parameters[name] != value for name, value in wanted.items()):
            raise ValueError(f"{path} was made of another stack, or with other parameters: leave --resume out.")
    same = takewhile(lambda pair: pair[0].number == pair[1], zip(earlier.pages, numbers, strict=False))
    known = tuple(page for page, _ in same)
    say(f"cpm: {counted(len(known), 'page')} done before.")
    return known


def _tell_notes(pages: Pages, number: int, parameters: Parameters) -> None:
    """Tell what was changed between the file and the gray levels of its first page that is run."""
    try:
        notes = notes_on(pages[number - 1], parameters)
    except ValueError:
        return  # told when it is run
    for note in notes:
        say(f"cpm: {pages.name}: {note}")


def _whole(pages: Pages, order: StackRun, found: Sequence[Page]) -> StackResult:
    return StackResult(pages.name, len(pages), tuple(found), pages.axis, pages.alone, tuple(order.drawn))


def _kept(pages: Pages, order: StackRun, found: Sequence[Page], wanted: int, exports: Sequence[str]) -> str:
    """Write the pages that are done; what an interrupt says then."""
    whole, refused = _whole(pages, order, found), dict[Path, str]()
    if not (whole.results and exports):
        return ""
    export_stack(whole, *exports, refused=refused.__setitem__)
    done = f"{len(found)} of {counted(wanted, 'page')} were done, and the files hold them"
    return f"{done}; the same command with --resume does the others" if _kept_in(exports) else done


def _report(found: StackResult, files: Files, seconds: float, *, as_json: bool) -> None:
    tracks, failed = found.tracks, len(found.pages) - len(found.results)
    if as_json:
        plain = [
            {
                "page": page.number,
                **({} if page.result is None else _facts(page)),
                "events": [event.sentence for event in page.events],
                "trouble": page.trouble,
            }
            for page in found.pages
        ]
        counts = {"tracks": len(tracks), "done": len(found.results), "failed": failed, "seconds": round(seconds, 3)}
        print_json("run", {"pages": plain, **counts, "not_written": files.refused})
        return
    for page in found.pages:
        if page.result is not None:
            closed = sum(contour.closed for contour in page.contours)
            print(f"page {page.number}: {counted(len(page.contours), 'contour')} ({closed} closed)")
    for page in found.pages:
        for event in page.events:
            print(event.sentence)
    failures = f", {failed} failed" if failed else ""
    told = f"{counted(len(found.pages), 'page')}, {counted(len(tracks), 'track')}"
    print(f"{found.source}: {told} in {seconds:.2f} s{failures}")
    for path in files.written:
        print(printable(f"Wrote {path}"))


def _facts(page: Page) -> dict[str, object]:
    """Outcome of the run on a page; the time of one page is not known."""
    assert page.result is not None
    facts = outcome_of(page.result, 0.0)
    del facts["seconds"]
    return facts
