"""``cpm figures``: repeats the experiments of the gallery and writes their pictures."""

from __future__ import annotations

import argparse
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cpm_core.cli.arguments import add_json
from cpm_core.cli.figures.figures import FIGURES, Figure, write_figures
from cpm_core.cli.outcome import tell
from cpm_core.cli.terminal import counted


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("figures", help="repeat the experiments of the gallery", allow_abbrev=False)
    parser.set_defaults(command=_figures)
    parser.description = (
        "Repeat the experiments of the gallery: one picture for each, an index, and all measured values. "
        "It takes a minute or two, and needs matplotlib."
    )
    parser.add_argument("--output", metavar="DIR", required=True, help="folder to write to; made when it is missing")
    parser.add_argument(
        "--only",
        metavar="NAME",
        nargs="+",
        action="extend",
        default=[],
        help=f"make only these ({', '.join(FIGURES)})",
    )
    add_json(parser)


def _figures(arguments: argparse.Namespace) -> None:
    """Make figures, with a line for each that is finished."""
    began = time.perf_counter()
    made: list[dict[str, Any]] = []

    def report(figure: Figure, entry: Mapping[str, Any]) -> None:
        nonlocal began
        now = time.perf_counter()
        made.append({"name": figure.name, **entry, "seconds": now - began})
        if not arguments.json:
            print(f"{figure.name}  {now - began:4.1f} s  {figure.title}: {entry['measured']}", flush=True)
        began = now

    written = write_figures(Path(arguments.output), arguments.only, report)
    facts = {"output": str(arguments.output), "figures": made, "files": [path.name for path in written]}
    tell(
        "figures", facts, (f"Wrote {counted(len(written), 'file')} to {arguments.output}",), (), as_json=arguments.json
    )
