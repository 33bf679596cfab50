"""``cpm completion``: a script with which a shell completes commands, options and files."""

from __future__ import annotations

import argparse

from cpm_core.cli.help.shells import bash, fish, powershell, zsh
from cpm_core.cli.help.words import words_of

_SHELLS = {"bash": bash.script, "zsh": zsh.script, "fish": fish.script, "powershell": powershell.script}


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add this command to those of the command line."""
    parser = commands.add_parser("completion", help="complete commands in your shell", allow_abbrev=False)
    parser.description = "Print a script for a shell, with which the tab key completes commands, options and files."
    parser.add_argument("shell", choices=tuple(_SHELLS), help="which shell")
    parser.set_defaults(command=lambda arguments: print(_SHELLS[arguments.shell](words_of(commands)), end=""))
