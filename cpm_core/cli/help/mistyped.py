"""What may have been meant by a word that is no command, no option and no file."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable

from cpm_core.parameters.quotation import shown

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
