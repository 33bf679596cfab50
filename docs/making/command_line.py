"""What every command says to ``--help all``."""

from __future__ import annotations

import contextlib
import io
import os
import re

from cpm_core import cli

_WIDTH = "84"


def text() -> str:
    """Write a section for each command."""
    commands = re.findall(r"^    (\w+)(?: |$)", help_of(), flags=re.MULTILINE)
    if not commands:
        raise ValueError("cpm --help lists no commands any more: correct docs/making/command_line.py.")
    parts = [f"## cpm\n\n```text\n{help_of()}```\n"]
    parts += [f"## cpm {command}\n\n```text\n{help_of(command)}```\n" for command in commands]
    return "\n".join(parts)


def help_of(*command: str) -> str:
    """Return what a command prints for ``--help all``."""
    stream = io.StringIO()
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = _WIDTH
    try:
        with contextlib.redirect_stdout(stream), contextlib.suppress(SystemExit):
            cli.main([*command, "--help", "all"])
    finally:
        if before is None:
            del os.environ["COLUMNS"]
        else:
            os.environ["COLUMNS"] = before
    return stream.getvalue()
