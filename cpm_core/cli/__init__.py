"""Command line: each command is a module of this package that adds its arguments and runs. No window."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from cpm_core.cli import bench, help, info
from cpm_core.cli import compare as compare_command
from cpm_core.cli import export as export_command
from cpm_core.cli import skeleton as skeleton_command
from cpm_core.cli.batch import command as batch_command
from cpm_core.cli.help import complete, is_examples, text_of, with_suggestion
from cpm_core.cli.inputs import use_files
from cpm_core.cli.run import command as run_command
from cpm_core.cli.terminal import drop_output, say, take_any_character
from cpm_core.formats.common.atomic import written_files
from cpm_core.formats.common.provenance import VERSION
from cpm_core.parameters.quotation import counted

_MODULES = (
    run_command,
    batch_command,
    export_command,
    skeleton_command,
    compare_command,
    info,
    bench,
    help,
)
"""A module for each command, in the order of the help."""

BAD_INPUT = 2
INTERRUPTED = 130
NOBODY_READS = 141
"""As the shell reports a program that wrote to a closed pipe."""


_NEGATIVE = re.compile(r"-(?:\.?\d|inf|nan)", re.IGNORECASE)
"""How values begin that are no options: a negative number, or several numbers between commas."""


class _Help(argparse.HelpFormatter):
    """Help that keeps the lines of examples."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        return text if is_examples(text) else super()._fill_text(text, width, indent)


class _Parser(argparse.ArgumentParser):
    """Parser that raises ValueError, which `main` reports."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{"formatter_class": _Help, **settings})
        self._negative_number_matcher = _NEGATIVE  # argparse's own takes -50,-50,3 and -1e-3 for options

    def error(self, message: str) -> NoReturn:
        raise ValueError(f"{with_suggestion(message, _options_of(self))} See {self.prog} --help.")

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print help; argparse's own hides that nothing could be written."""
        if message:
            print(message, end="", file=file or sys.stderr)


def _options_of(parser: argparse.ArgumentParser) -> set[str]:
    """All options of a parser and of its commands."""
    options = set(parser._option_string_actions)
    for action in parser._actions:
        for command in action.choices.values() if isinstance(action, argparse._SubParsersAction) else ():
            options |= set(command._option_string_actions)
    return options


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : sequence of str, optional
        Arguments after the program's name; those of the process when left out.

    Returns
    -------
    int
        Exit status: 0 on success, 1 when only some of several images, pages or files were done, 2 on bad input (one
        line on standard error; nothing is written), 130 when interrupted (one line that says what was written), 141
        when nobody reads the output any more.
    """
    take_any_character()
    with written_files() as written:
        try:
            return _run(argv)
        except ValueError as error:
            say(f"cpm: {error}")
            return BAD_INPUT
        except MemoryError:
            say("cpm: there is not enough memory for this: use a smaller image or fewer particles.")
            return BAD_INPUT
        except KeyboardInterrupt as interrupt:
            files = f"{counted(len(written), 'file')} {'was' if len(written) == 1 else 'were'} written before"
            say(f"cpm: interrupted; {str(interrupt) or (files if written else 'nothing was written')}.")
            return INTERRUPTED
        except BrokenPipeError:
            drop_output()
            return NOBODY_READS
        except OSError as error:
            drop_output()
            say(f"cpm: the output cannot be written: {error.strerror or error}.")
            return BAD_INPUT


def _run(argv: Sequence[str] | None) -> int:
    try:
        whole = parser()
        complete(whole)
        arguments = whole.parse_args(argv)
        use_files(arguments)
        command: Callable[[argparse.Namespace], int | None] = arguments.command
        return command(arguments) or 0
    finally:
        if sys.stdout is not None:
            sys.stdout.flush()


def parser() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    whole = _Parser(
        prog="cpm",
        description="Find contours in images with charged particles.",
        epilog="Without a command the window opens, on the image that is named if there is one: cpm [IMAGE].",
        allow_abbrev=False,
    )
    whole.add_argument("--version", action="version", version=f"cpm {VERSION}", help="show the version")
    commands = whole.add_subparsers(metavar="COMMAND", dest="name", required=True)
    for module in _MODULES:
        module.add_to(commands)
    for name, command in commands.choices.items():
        command.epilog = text_of(name)
    return whole
