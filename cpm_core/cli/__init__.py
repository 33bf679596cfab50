"""Command line: each command is a module of this package that adds its arguments and runs. No window."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn

from cpm_core.cli import info, run, skeleton
from cpm_core.cli.batch import command as batch_command
from cpm_core.cli.bench import command as bench_command
from cpm_core.cli.figures import command as figures_command

BAD_INPUT = 2
INTERRUPTED = 130


class _Parser(argparse.ArgumentParser):
    """Parser that raises ValueError, which `main` reports."""

    def error(self, message: str) -> NoReturn:
        raise ValueError(f"{message} (see {self.prog} --help).")


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments after the program's name; those of the process when left out.

    Returns
    -------
    int
        Exit status: 0 on success, 1 when some of several images failed, 2 on bad input (one line on standard
        error, nothing written), 130 when interrupted.
    """
    try:
        arguments = _parser().parse_args(argv)
        command: Callable[[argparse.Namespace], int | None] = arguments.command
        return command(arguments) or 0
    except ValueError as error:
        print(f"cpm: {error}", file=sys.stderr)
        return BAD_INPUT
    except MemoryError:
        print("cpm: there is not enough memory for this: use a smaller image or fewer particles.", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt as interrupt:
        print(f"cpm: interrupted; {str(interrupt) or 'nothing was written'}.", file=sys.stderr)
        return INTERRUPTED


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="cpm",
        description="Find contours in images with charged particles.",
        epilog="Without a command the window opens, on the image that is named if there is one: cpm [IMAGE].",
        allow_abbrev=False,
    )
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in (run, batch_command, skeleton, info, figures_command, bench_command):
        command.add_to(commands)
    return parser
