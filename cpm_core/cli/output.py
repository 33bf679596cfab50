"""Output of commands: sentences and progress for the user, one JSON object for programs, and the files they wrote.

Each object begins with ``command``, ``schema`` (the version of the schema) and ``version`` (of CPM). The rest is in
`SCHEMA_FILE`, a JSON Schema of all commands; its number is raised when an entry changes its meaning or is removed.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, redirect_stdout
from contextvars import ContextVar
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from cpm_core.formats import export
from cpm_core.formats.common.printable import make_printable
from cpm_core.formats.common.provenance import VERSION
from cpm_core.image.image import Image
from cpm_core.model.state import State
from cpm_core.numerics.types import JsonObject
from cpm_core.parameters.formatting import format_count
from cpm_core.results.result import Result
from cpm_core.warm_up import FIRST, VOLUMES, is_compiled, warm_up

SCHEMA_VERSION = 1
"""Version of the schema of all JSON objects."""

SCHEMA_FILE = Path(__file__).with_name("outcome.schema.json")
"""JSON Schema of what the commands print with ``--json``."""

EXIT_IN_PART = 1
"""Exit status when only some of several images, pages or files could be done."""

_MINUTES_FROM = 180.0
"""Remaining time from which it is given in minutes [s]."""

_REDRAW_INTERVAL = 0.1
"""Shortest time between two changes of a line of progress [s]."""


STANDARD_STREAM = "-"
"""Name of standard input as an image, and first character of a name for standard output, before its suffix."""

_QUIET = ContextVar("quiet", default=False)
"""Whether only errors are printed."""


@contextmanager
def direct_output(exports: list[str], *, quiet: bool, as_json: bool) -> Iterator[None]:
    """Print errors alone in the block if `quiet`, and copy the file named for standard output there after it.

    A name such as ``-.csv`` among the `exports` is replaced by that of a temporary file. ValueError for several, and
    for one with JSON.
    """
    named = [at for at, path in enumerate(exports) if os.path.splitext(path)[0] == STANDARD_STREAM]  # noqa: PTH122
    if STANDARD_STREAM in exports:
        raise ValueError("- alone names no format: add a suffix, such as -.csv.")
    if len(named) + (as_json and bool(named)) > 1:
        raise ValueError("Standard output can take one file, without --json: write the others to files of their own.")
    before = _QUIET.set(quiet)
    with ExitStack() as stack:
        if (quiet or named) and not as_json:
            stack.enter_context(redirect_stdout(stack.enter_context(open(os.devnull, "w", encoding="utf-8"))))  # noqa: PTH123
        folder = Path(stack.enter_context(TemporaryDirectory(prefix="cpm-"))) if named else Path()
        for at in named:
            exports[at] = str(folder / f"stdout{exports[at][1:]}")
        try:
            yield
        finally:
            _QUIET.reset(before)
        written = sorted(folder.iterdir()) if named else []
        if len(written) > 1:
            raise ValueError("Standard output can take one file, but there are several: write them to files.")
        contents = [path.read_bytes() for path in written]
    for content in contents:
        sys.stdout.flush()
        sys.stdout.buffer.write(content)


def print_message(message: str) -> None:
    """Print a message to standard error."""
    print(make_printable(f"cpm: {message}"), file=sys.stderr, flush=True)


def print_note(note: str) -> None:
    """Print what is no error to standard error."""
    if not _QUIET.get():
        print_message(note)


def print_notes(source: str, notes: Iterable[str]) -> None:
    """Print notes on an image or another file to standard error."""
    for note in notes:
        print_note(f"{source}: {note}")


class StatusLine:
    """A line of progress on standard error if that is a terminal; it is removed at the end of the block."""

    def __init__(self) -> None:
        self._due = 0.0
        self.begin_count("")

    def __enter__(self) -> StatusLine:
        return self

    def __exit__(self, *_: object) -> None:
        self.show_text("")

    def show_text(self, text: str) -> None:
        """Show a text in place of the last one."""
        if sys.stderr.isatty() and not _QUIET.get():
            print(f"\r\x1b[2K{text}", end="", file=sys.stderr, flush=True)

    def show_state(self, state: State) -> None:
        """Show the state of a run, from time to time."""
        now = time.monotonic()
        if now >= self._due:
            self._due = now + _REDRAW_INTERVAL
            self.show_text(f"step {state.step}  scale {state.scale}  particles {state.count}")

    def begin_count(self, title: str) -> None:
        """Start counting items of a kind."""
        self._title, self._began = f"{title}: " if title else "", time.monotonic()

    def show_count(self, done: int, total: int) -> None:
        """Show how many items are done, and the approximate time for the others."""
        left = (time.monotonic() - self._began) / done * (total - done)
        time_left = f"{left:.0f} s" if left < _MINUTES_FROM else f"{left / 60.0:.0f} min"
        self.show_text(f"{self._title}{done} of {total}" + (f", about {time_left} left" if left else ""))

    def print_above(self, message: str) -> None:
        """Print a message above the line."""
        self.show_text("")
        print_message(message)


def ensure_compiled(*, volume: bool = False) -> None:
    """Compile the kernels of a run, on an image or in a volume, in advance if necessary, and tell the user."""
    if not is_compiled(volume=volume):
        print_note("the inner loops are compiled for this computer, once; the run begins in ten to twenty seconds.")
        with StatusLine() as line:
            parts = VOLUMES if volume else FIRST
            warm_up(on_progress=lambda done: line.show_text(f"compiling: {done:.0%}"), parts=parts)


class OutputFiles:
    """The files that a command writes: those that are written, and the reasons why others are not."""

    def __init__(self) -> None:
        self.written: list[str] = []
        self.refused: dict[str, str] = {}

    def export_result(self, result: Any, paths: Sequence[str], **options: Any) -> None:
        """Write a result, with options of `export`, to those of the paths whose formats can hold it."""
        with self.record_writing(*paths):
            export(result, *paths, refused=self.refuse_file, **options)

    def refuse_file(self, path: str | Path, reason: str) -> None:
        """Record that a file is not written, and why."""
        self.refused[str(path)] = reason

    @contextmanager
    def record_writing(self, *paths: str) -> Iterator[None]:
        """Record the files that the block writes: all that it does not refuse, or none when it raises ValueError."""
        try:
            yield
        except ValueError as error:
            for path in paths:
                self.refused.setdefault(path, str(error))
        known = {str(Path(path)) for path in self.refused}
        self.written += [path for path in dict.fromkeys(paths) if str(Path(path)) not in known]


def print_json(command: str, facts: JsonObject) -> None:
    """Print the outcome of a command as one JSON object."""
    print(json.dumps({"command": command, "schema": SCHEMA_VERSION, "version": VERSION, **facts}))


def print_report(
    command: str, as_json: bool, facts: JsonObject, lines: Iterable[str], files: OutputFiles, advice: str = ""
) -> int:
    """Print the outcome of a command as JSON, or as sentences with the files that were written; return the exit status.

    Files that are not written come first, with `advice`. ValueError when none is written.
    """
    for path, reason in files.refused.items():
        if not files.written:
            raise ValueError(f"{reason} {advice}".rstrip())
        print_message(f"{path} was not written: {reason} {advice}".rstrip())
    if as_json:
        print_json(command, {**facts, "not_written": files.refused})
    else:
        for line in (*lines, *(f"Wrote {path}" for path in files.written)):
            print(make_printable(line))
    return EXIT_IN_PART if files.refused else 0


def collect_run_facts(result: Result) -> dict[str, object]:
    """Return values of a run by name, as they are printed as JSON."""
    return {
        "particles": len(result.particles),
        "contours": len(result.contours),
        "closed": sum(contour.closed for contour in result.contours),
        "steps": result.steps,
        "converged": result.converged,
        "stop_reason": result.stop_reason,
    }


def describe_contour_count(found: Any, kind: str = "contour") -> str:
    """Return the number of the contours of a result, in words."""
    closed = sum(contour.closed for contour in found.contours)
    return f"{format_count(len(found.contours), kind)} ({closed} closed)"


def list_longest(lines: Sequence[str]) -> list[str]:
    """Return the first ten of some lines on contours, the longest first, with numbers."""
    more = [f"  ... and {len(lines) - 10} shorter ones"] if len(lines) > 10 else []
    return [f"  {number}. {line}" for number, line in enumerate(lines[:10], start=1)] + more


_AXIS_PLURALS = ("planes", "rows", "columns")
"""Names of what is counted along the axes."""

_DIRECTION_WORDS = {"L": "left", "R": "right", "P": "back", "A": "front", "S": "head", "I": "feet"}
"""Directions in a patient by their letters."""

_MIN_OBLIQUE_ANGLE = 0.05
"""Smallest angle at which axes are called oblique [degrees]."""


def describe_geometry(image: Image) -> list[str]:
    """Return lines on the size of a pixel or voxel, and on orientation and position where they are known."""
    what = "pixel" if image.ndim == 2 else "voxel"
    size = "not given in the file"
    if image.unit:
        order = " x ".join(("plane", "row", "column")[-image.ndim :])
        size = f"{' x '.join(f'{side:g}' for side in image.spacing)} {image.unit} ({order})"
    lines, geometry = [f"Size of a {what}: {size}"], image.geometry
    if geometry is not None:
        ways = [
            f"{axis} to the {_DIRECTION_WORDS[letter]}"
            for axis, letter in zip(_AXIS_PLURALS, geometry.letters, strict=True)
        ]
        turned = f", up to {geometry.oblique:.1f}° oblique" if geometry.oblique >= _MIN_OBLIQUE_ANGLE else ""
        origin = ", ".join(f"{at:g}" for at in geometry.origin)
        lines.append(f"Orientation: {', '.join(ways[-image.ndim :])}{turned}")
        lines.append(f"First {what}: at ({origin}) {image.unit or 'voxels'}, {geometry.convention}")
    return lines


def collect_geometry_facts(image: Image) -> dict[str, object]:
    """Return size of a pixel or voxel, orientation and position as values by name."""
    geometry = image.geometry
    place = geometry and {
        "origin": list(geometry.origin),
        "directions": [list(direction) for direction in geometry.directions],
        "convention": geometry.convention,
        "letters": "".join(geometry.letters),
        "affine": geometry.affine(image.spacing).tolist(),
    }
    return {"spacing": list(image.spacing) if image.unit else None, "unit": image.unit, "geometry": place}
