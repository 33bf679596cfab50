"""``cpm figures``: does the experiments of the gallery again and writes their pictures."""

from __future__ import annotations

import argparse
import time
from pathlib import Path

from cpm_core.cli.figures.figures import FIGURES, Figure, write_figures
from cpm_core.cli.terminal import counted


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("figures", help="do the experiments of the gallery again", allow_abbrev=False)
    parser.set_defaults(command=_figures)
    parser.description = (
        "Do the experiments of the gallery again: one picture for each, an index, and all that was measured. "
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


def _figures(arguments: argparse.Namespace) -> None:
    """Make figures, a line for each that is done."""
    began = time.perf_counter()

    def tell(figure: Figure, measured: str) -> None:
        nonlocal began
        now = time.perf_counter()
        print(f"{figure.name}  {now - began:4.1f} s  {figure.title}: {measured}", flush=True)
        began = now

    written = write_figures(Path(arguments.output), arguments.only, tell)
    print(f"Wrote {counted(len(written), 'file')} to {arguments.output}")
