"""Command line: each command is a module of this package that adds its arguments and runs. No window."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn

from cpm_core.cli import info
from cpm_core.cli.batch import command as batch_command
from cpm_core.cli.bench import command as bench_command
from cpm_core.cli.compare import command as compare_command
from cpm_core.cli.figures import command as figures_command
from cpm_core.cli.run import command as run_command
from cpm_core.cli.skeleton import command as skeleton_command
from cpm_core.cli.terminal import drop_output, say, take_any_character
from cpm_core.formats.provenance import VERSION

BAD_INPUT = 2
INTERRUPTED = 130
NOBODY_READS = 141
"""As the shell reports a program that wrote to a closed pipe."""


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
        error, nothing written), 130 when interrupted, 141 when nobody reads the output any more.
    """
    take_any_character()
    try:
        try:
            arguments = _parser().parse_args(argv)
            command: Callable[[argparse.Namespace], int | None] = arguments.command
            return command(arguments) or 0
        finally:
            if sys.stdout is not None:
                sys.stdout.flush()
    except ValueError as error:
        say(f"cpm: {error}")
        return BAD_INPUT
    except MemoryError:
        say("cpm: there is not enough memory for this: use a smaller image or fewer particles.")
        return BAD_INPUT
    except KeyboardInterrupt as interrupt:
        say(f"cpm: interrupted; {str(interrupt) or 'nothing was written'}.")
        return INTERRUPTED
    except BrokenPipeError:
        drop_output()
        return NOBODY_READS
    except OSError as error:
        drop_output()
        say(f"cpm: the output cannot be written: {error.strerror or error}.")
        return BAD_INPUT


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="cpm",
        description="Find contours in images with charged particles.",
        epilog="Without a command the window opens, on the image that is named if there is one: cpm [IMAGE].",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"cpm {VERSION}", help="show the version")
    commands = parser.add_subparsers(metavar="COMMAND", required=True)
    for command in (
        run_command,
        batch_command,
        skeleton_command,
        compare_command,
        info,
        figures_command,
        bench_command,
    ):
        command.add_to(commands)
    return parser
