"""The outcome of a command: one JSON object of a documented form, or sentences for a person.

Each object begins with ``command``, ``schema`` (the version of the form) and ``version`` (that of CPM). What follows is
in `SCHEMA_FILE`, a JSON Schema of all commands; its number is raised when an entry changes its meaning or goes.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from cpm_core.contours.result import Result
from cpm_core.formats.printable import printable
from cpm_core.formats.provenance import VERSION

SCHEMA = 1
"""Version of the form of all JSON objects."""

SCHEMA_FILE = Path(__file__).with_name("outcome.schema.json")
"""JSON Schema of what the commands print with ``--json``."""


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
