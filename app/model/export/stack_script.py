"""What was done on the pages of a stack as a script: a program in Python, and where it can, a command line."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from app.model.document.document import Document
from app.model.export.script import (
    Script,
    arguments,
    changed,
    flag,
    head,
    imported,
    in_order,
    in_words,
    listed,
    written_out,
)
from app.model.text.language import tr
from cpm_core.parameters import Parameters
from cpm_core.shapes import Circle, Everywhere, Shape, Start, Stroke

_FLAGS = ("time", "channel", "series")
"""Parts of a file that the command line has flags of the same name for, beside the page."""


@dataclass(frozen=True, eq=False, slots=True)
class DrawnPages:
    """What is drawn on the pages of a stack that are run.

    Attributes
    ----------
    path : str
        The stack.
    reading : mapping
        What `load_pages` is told beside the path.
    count : int
        Number of its pages.
    following : bool
        Whether each page starts from the contours of the one before.
    first : int
        The first page that is run, from 1.
    document : Document
        What that page is run with: its start, limits, charges and parameters.
    own : mapping of int to Document
        Later pages with a start of their own.
    """

    path: str
    reading: Mapping[str, Any]
    count: int
    following: bool
    first: int
    document: Document
    own: Mapping[int, Document] = field(default_factory=dict)

    @property
    def more(self) -> bool:
        """Whether single pages have decisions on contours, or limits and charges other than those of the first."""
        return any(
            one.marks or one.hand_edits or _limits(one) != _limits(self.document)
            for one in (self.document, *self.own.values())
        )


def script_of_stack(pages: DrawnPages) -> Script:
    """The script of all pages."""
    note = ""
    if pages.more:
        note = tr("Edits and decisions on contours are left out, and all pages have the limits of the first.")
    return Script(_python(pages), "" if pages.own else _command(pages), False, note)


def _python(pages: DrawnPages) -> str:
    shapes = pages.document.shapes
    own = {number: document.starts for number, document in sorted(pages.own.items())}
    starts = (
        "def seeds(image, drawn=shapes):",
        "    return seeds_on(image, drawn, parameters.smoothing, parameters.channel)",
        "",
        "limits = {'regions': regions_of(shapes), 'charges': charges_of(shapes)}",
    )
    every = ("own = {", *(f"    {number}: {drawn!r}," for number, drawn in own.items()), "}") if own else ()
    return "\n".join(
        (
            *head(Path(pages.path).name),
            "from cpm_core.formats.contours.pages.files import export_stack",
            "from cpm_core.segmentation.pages.page import StackResult",
            *imported([*shapes, *(shape for drawn in own.values() for shape in drawn)]),
            "",
            f"pages = cpm.load_pages({arguments(pages.path, dict(pages.reading))})",
            *written_out("parameters", "cpm.Parameters", changed(pages.document.parameters, Parameters())),
            *listed("shapes", shapes),
            *every,
            "",
            *starts,
            "",
            *(_page_by_page(pages) if own else _all_at_once(pages)),
            "result = StackResult(pages.name, len(pages), tuple(found), pages.axis, pages.alone)",
            f"export_stack(result, {_result(pages)!r})",
            "",
        )
    )


def _all_at_once(pages: DrawnPages) -> tuple[str, ...]:
    fresh = "" if pages.following else ", fresh=True"
    numbers = f", numbers=range({pages.first}, len(pages) + 1)" if pages.first > 1 else ""
    return (f"found = list(cpm.follow(pages, seeds, parameters{numbers}{fresh}, **limits))",)


def _page_by_page(pages: DrawnPages) -> tuple[str, ...]:
    """Pages with a start of their own begin anew."""
    return (
        "found = []",
        f"for number in range({pages.first}, len(pages) + 1):",
        "    drawn = own.get(number, shapes)",
        f"    anew = {'number in own' if pages.following else 'True'}",
        "    found += cpm.follow(",
        "        pages, lambda image: seeds(image, drawn), parameters,",
        "        numbers=[number], fresh=anew, known=found, **limits,",
        "    )",
    )


def _command(pages: DrawnPages) -> str:
    """The command with everything as flags; empty where it lacks one."""
    shapes = pages.document.shapes
    if not set(pages.reading) <= set(_FLAGS) or not in_order(shapes, (Circle, Stroke, Everywhere)):
        return ""
    drawn = [part for shape in shapes for part in flag(shape)]
    part = [word for name, value in pages.reading.items() for word in (f"--{name}", f"{value}")]
    chosen = "all" if pages.first == 1 else f"{pages.first}-{pages.count}"
    following = ("--follow",) if pages.following else ()
    given = in_words(changed(pages.document.parameters, Parameters()))
    path = str(Path(pages.path).absolute())
    line = ("cpm", "run", path, *drawn, *given, *part, "--pages", chosen, *following, "--export", _result(pages))
    return shlex.join(line)


def _limits(document: Document) -> tuple[Shape, ...]:
    return tuple(shape for shape in document.shapes if not isinstance(shape, Start))


def _result(pages: DrawnPages) -> str:
    return f"{Path(pages.path).stem}_pages.json"
