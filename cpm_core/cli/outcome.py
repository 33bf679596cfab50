"""The outcome of a command: one JSON object of a documented form, or sentences for a person.

Each object begins with ``command``, ``schema`` (the version of the form) and ``version`` (that of CPM). What follows is
in `SCHEMA_FILE`, a JSON Schema of all commands; its number is raised when an entry changes its meaning or goes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cpm_core.cli.terminal import say
from cpm_core.contours.result import Result
from cpm_core.formats import export
from cpm_core.formats.common.printable import printable
from cpm_core.formats.common.provenance import VERSION
from cpm_core.parameters.quotation import counted

SCHEMA = 1
"""Version of the form of all JSON objects."""

SCHEMA_FILE = Path(__file__).with_name("outcome.schema.json")
"""JSON Schema of what the commands print with ``--json``."""


IN_PART = 1
"""Exit status when some of several images, pages or files could not be done, and the others were."""

_NAMED = 5
"""Most files that a sentence names."""


class Files:
    """The files that a command writes: those that are written, and why others are not."""

    def __init__(self) -> None:
        self.written: list[str] = []
        self.refused: dict[str, str] = {}
        self.advice = ""
        """What to do, told with the files that are not written."""
        self._failure = ""

    def export(self, result: Any, paths: Sequence[str], **options: Any) -> None:
        """Write a result, with options of `export`, to those of some paths whose formats can hold it."""
        with self.writing(*paths):
            export(result, *paths, refused=self.refuse, **options)

    def refuse(self, path: str | Path, reason: str) -> None:
        """Note that a file is not written, and why."""
        self.refused[str(path)] = reason

    @contextmanager
    def writing(self, *paths: str) -> Iterator[None]:
        """Write some files within the block: all that it does not refuse, or none when it raises ValueError."""
        try:
            yield
        except ValueError as error:
            self._failure = self._failure or str(error)
            for path in paths:
                self.refused.setdefault(path, str(error))
        known = {str(Path(path)) for path in self.refused}
        self.written += [path for path in dict.fromkeys(paths) if str(Path(path)) not in known]

    def check(self) -> None:
        """Raise ValueError when files were to be written and none was."""
        if self.refused and not self.written:
            raise ValueError(f"{self._failure or self._reasons()} {self.advice}".rstrip())

    def status(self) -> int:
        """Exit status of the command; a sentence tells what is written and what is not when that is only a part."""
        if not self.refused:
            return 0
        say(f"cpm: {_listed(self.written)} written, but {self._reasons()} {self.advice}".rstrip())
        return IN_PART

    def _reasons(self) -> str:
        """Which files are not written and why; files with the same reason are named together."""
        why: dict[str, list[str]] = {}
        for path, reason in self.refused.items():
            why.setdefault(reason, []).append(path)
        return " ".join(f"{_listed(paths)} not written: {reason}" for reason, paths in why.items())


def _listed(paths: Sequence[str]) -> str:
    """Some paths and their verb, as in "a.svg and b.csv were"; of many the first alone."""
    named = [*paths] if len(paths) <= _NAMED else [*paths[: _NAMED - 1], counted(len(paths) - _NAMED + 1, "other file")]
    return f"{', '.join(named[:-1])} and {named[-1]} were" if named[1:] else f"{named[0]} was"


def print_json(command: str, facts: Mapping[str, Any]) -> None:
    """Print the outcome of a command as one JSON object."""
    print(json.dumps({"command": command, "schema": SCHEMA, "version": VERSION, **facts}))


def tell(
    command: str, facts: Mapping[str, Any], lines: Iterable[str], files: Iterable[object], *, as_json: bool
) -> None:
    """Print the outcome of a command as JSON, or as sentences with the files that were written."""
    if as_json:
        print_json(command, facts)
        return
    for line in lines:
        print(line)
    for path in files:
        print(printable(f"Wrote {path}"))


def outcome_of(result: Result, seconds: float) -> dict[str, object]:
    """Values of a run by name, as they are printed as JSON."""
    return {
        "particles": len(result.particles),
        "contours": len(result.contours),
        "closed": sum(contour.closed for contour in result.contours),
        "steps": result.steps,
        "converged": result.converged,
        "stop_reason": result.stop_reason,
        "seconds": round(seconds, 3),
    }
