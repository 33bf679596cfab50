"""Help on the command line: examples, what may have been meant, and completion in shells."""

from __future__ import annotations

import argparse
import difflib
import os
import re
from collections.abc import Iterable

import argcomplete
from argcomplete.shell_integration import shellcode

from cpm_core.parameters.quotation import shown

SHELLS = ("bash", "zsh", "fish", "powershell")

EXAMPLES: dict[str, tuple[tuple[str, str], ...]] = {
    "run": (
        ("from a circle, with the contours as a drawing", "cpm run cell.png --circle 120,80,30 --export cell.svg"),
        ("each page of a stack, from everywhere", "cpm run stack.tif --pages all --auto grid --export stack.csv"),
        ("from the contours of another program", "cpm run cell.png --start cell.roi --save-session cell.cpm"),
    ),
    "batch": (
        ("a folder, as a session says", "cpm batch images --session cell.cpm --output found"),
        ("some files, on two processors", 'cpm batch "images/*.png" --session cell.cpm --output found --workers 2'),
    ),
    "export": (
        ("what a session shows, for ImageJ and QuPath", "cpm export cell.cpm --to cell.zip cell.geojson"),
        ("a figure for a publication", "cpm export cell.cpm --to cell.figure.pdf"),
        ("from one format to another", "cpm export cell.svg --image cell.png --to cell.coco.json"),
        ("a surface of a volume as labels", "cpm export tree.ply --image angio.nii --to tree.nii.gz"),
    ),
    "skeleton": (
        ("the middle lines of dark vessels", "cpm skeleton retina.png --of dark --export vessels.svg"),
        ("center lines in a volume", "cpm skeleton angio.nii --volume --export tree.swc"),
    ),
    "compare": (
        ("all methods from one circle", "cpm compare cell.png --circle 120,80,30 --truth cell_mask.png"),
        ("two of them, as a table", "cpm compare cell.png --circle 120,80,30 --methods cpm gvf --export table.csv"),
        ("surfaces in a volume", "cpm compare angio.nii --sphere 20,64,64,4 --truth vessels.nii --export angio.ply"),
    ),
    "info": (
        ("what a file holds", "cpm info stack.tif"),
        ("all images of a folder, for a script", "cpm info images --json"),
    ),
    "bench": (
        ("how fast it is here", "cpm bench"),
        ("the same in a few seconds, for a script", "cpm bench --quick --json"),
    ),
    "completion": (
        ("for bash, in the file that it reads at its start", 'eval "$(cpm completion bash)"'),
        ("for fish, once", "cpm completion fish > ~/.config/fish/completions/cpm.fish"),
    ),
}
"""Command -> what an example does, and its line."""

_HEAD = "Examples:"


def text_of(command: str) -> str:
    """The end of the help of a command."""
    lines = [f"  {line}\n      {what}" for what, line in EXAMPLES[command]]
    return "\n".join([_HEAD, *lines])


def is_examples(text: str) -> bool:
    """Whether a text of the help keeps its lines as they are."""
    return text.startswith(_HEAD)


_LIKE = 0.6
"""How alike two words have to be, from 0 to 1."""


def nearest(word: str, known: Iterable[str]) -> str:
    """The known word that is most like another; empty where none is."""
    return next(iter(difflib.get_close_matches(word, list(known), 1, _LIKE)), "")


def no_command_or_file(word: str, commands: Iterable[str]) -> str:
    """A sentence on the first word of a command line that is neither a command nor a file."""
    near = nearest(word.lower(), commands) if re.fullmatch("[A-Za-z_-]+", word) else ""
    if near:
        return f"{shown(word)} is no command and no file: did you mean cpm {near}?"
    return f"{shown(word)} does not exist: check its name and folder, or see cpm --help."


def with_suggestion(message: str, options: Iterable[str]) -> str:
    """The message of a parser on what it does not know, with the option that may have been meant."""
    found = re.match(r"unrecognized arguments: (--[\w-]+)", message)
    near = nearest(found[1], options) if found else ""
    return f"{message}; did you mean {near}?" if near else f"{message}."


def add_to(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add ``cpm completion`` to the commands: a script with which a shell completes commands, options and files."""
    parser = commands.add_parser("completion", help="complete commands in your shell", allow_abbrev=False)
    parser.description = "Print a script for a shell, with which the tab key completes commands, options and files."
    parser.add_argument("shell", choices=SHELLS, help="which shell")
    parser.set_defaults(command=_completion)


def _completion(arguments: argparse.Namespace) -> None:
    print(shellcode(["cpm"], shell=arguments.shell))


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer a shell that asks what may follow, and end; nothing where none asks."""
    if "_ARGCOMPLETE" in os.environ:
        argcomplete.autocomplete(parser)
