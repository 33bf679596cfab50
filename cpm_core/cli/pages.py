"""``cpm run STACK --pages``: finds the contours on each page of a stack, and follows objects from page to page."""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path
from typing import Any

from cpm_core.cli.arguments import check_targets
from cpm_core.cli.inputs import notes_on
from cpm_core.cli.output import IN_PART, Files, StatusLine, announce_compilation, facts_of_run, report, say, say_notes
from cpm_core.field.placed_charges import PlacedCharge
from cpm_core.formats import load_pages
from cpm_core.formats.common.atomic import check_target
from cpm_core.formats.common.content import differ
from cpm_core.formats.contours.contour_json import load_stack_result
from cpm_core.formats.images.stack import Pages
from cpm_core.formats.stack_files import FOR_STACKS, export_stack, stack_suffix_of
from cpm_core.image.image import Image
from cpm_core.image.volume_regions import AnyRegions
from cpm_core.numerics.types import Array
from cpm_core.pages.follow import follow
from cpm_core.pages.page import Page, StackResult
from cpm_core.parameters import Parameters
from cpm_core.parameters.quotation import counted, shown

_NOT_OF_PAGES = ("page", "object", "close", "truth", "save_session")
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
        What `load_pages` is told in addition to the path.
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


def check_pages(arguments: argparse.Namespace, image: Path) -> None:
    """Raise ValueError for options that do not belong together, and for files that cannot be written."""
    for name in _NOT_OF_PAGES:
        if getattr(arguments, name):
            given = f"--{name.replace('_', '-')}"
            raise ValueError(f"{given} is for one image, but --pages runs several: leave one of them out.")
    for path in arguments.export:
        check_target(path, FOR_STACKS)
    check_targets(arguments.export, arguments, image)
    if arguments.resume and not _kept_in(arguments.export):
        raise ValueError("--resume needs the .json file that holds the pages that are done: add it to --export.")


def run_pages(arguments: argparse.Namespace, order: StackRun) -> int:
    """Run the pages, and write what is found on all of them; what is done is written on Ctrl+C too."""
    pages = load_pages(order.path, **order.part)
    numbers = numbers_of_pages(arguments.pages, len(pages), pages.name)
    found = _known(arguments, order, pages, numbers)
    left = numbers[len(found) :]
    with suppress(ValueError):  # which is reported when the page is run
        say_notes(pages.name, notes_on(pages[numbers[0] - 1], order.parameters))
    announce_compilation()
    began, saved = time.perf_counter(), time.monotonic()

    def whole() -> StackResult:
        return StackResult(pages.name, len(pages), tuple(found), pages.axis, pages.alone, tuple(order.drawn))

    runs = follow(
        pages,
        order.seeds,
        order.parameters,
        numbers=left,
        fresh=not arguments.follow,
        max_steps=order.max_steps,
        regions=order.regions,
        charges=order.charges,
        known=tuple(found),
    )
    files = Files()
    try:
        with StatusLine() as line:
            for done, page in enumerate(runs, start=1):
                found.append(page)
                line.count(done, len(left))
                if page.trouble:
                    line.say(f"page {page.number}: {page.trouble}")
                if time.monotonic() - saved > _SAVED_EVERY:
                    saved = time.monotonic()
                    export_stack(whole(), *_kept_in(arguments.export))
    except KeyboardInterrupt:
        if not (whole().results and arguments.export):
            raise
        export_stack(whole(), *arguments.export, refused=files.refuse)
        text = f"{len(found)} of {counted(len(numbers), 'page')} were done, and the files hold them"
        more = "; the same command with --resume does the others" if _kept_in(arguments.export) else ""
        raise KeyboardInterrupt(f"{text}{more}") from None
    if not whole().results:
        raise ValueError(f"No page of {pages.name} could be used. Page {found[0].number}: {found[0].trouble}")
    with files.writing(*arguments.export):
        export_stack(whole(), *arguments.export, refused=files.refuse)
    status = files.status()
    _report(whole(), files, time.perf_counter() - began, as_json=arguments.json)
    return status or (IN_PART if len(whole().results) < len(found) else 0)


def numbers_of_pages(given: str, count: int, name: str) -> list[int]:
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


def _known(arguments: argparse.Namespace, order: StackRun, pages: Pages, numbers: Sequence[int]) -> list[Page]:
    """The pages that an earlier run has done, as far as they are the first of those that are wanted."""
    if not arguments.resume:
        return []
    path = _kept_in(arguments.export)[0]
    if not Path(path).exists():
        say(f"{path} does not exist yet: all pages are run.")
        return []
    earlier = load_stack_result(Path(path))
    for _, result in earlier.results:
        made = result.provenance
        wanted = {name: getattr(order.parameters, name) for name in made.parameters if name != "scales"}
        if differ(made.sha256, pages.sha256) or any(made.parameters[name] != value for name, value in wanted.items()):
            raise ValueError(f"{path} was made of another stack, or with other parameters: leave --resume out.")
    same = takewhile(lambda pair: pair[0].number == pair[1], zip(earlier.pages, numbers, strict=False))
    known = [page for page, _ in same]
    say(f"{counted(len(known), 'page')} done before.")
    return known


def _report(found: StackResult, files: Files, seconds: float, *, as_json: bool) -> None:
    plain: list[dict[str, Any]] = []
    lines: list[str] = []
    for page in found.pages:
        facts = {} if page.result is None else facts_of_run(page.result, 0.0)
        facts.pop("seconds", None)  # that of one page is not known
        events = [event.sentence for event in page.events]
        plain.append({"page": page.number, **facts, "events": events, "trouble": page.trouble})
        if page.result is not None:
            closed = sum(contour.closed for contour in page.contours)
            lines.append(f"page {page.number}: {counted(len(page.contours), 'contour')} ({closed} closed)")
    tracks, failed = len(found.tracks), len(found.pages) - len(found.results)
    failures = f", {failed} failed" if failed else ""
    lines += [event.sentence for page in found.pages for event in page.events]
    lines.append(
        f"{found.source}: {counted(len(found.pages), 'page')}, {counted(tracks, 'track')} in {seconds:.2f} s{failures}"
    )
    counts = {"tracks": tracks, "done": len(found.results), "failed": failed, "seconds": round(seconds, 3)}
    report("run", {"pages": plain, **counts}, lines, files, as_json=as_json)
