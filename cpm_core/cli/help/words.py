"""The words of the command line: commands, their options, and the values of these, as the parsers know them."""

from __future__ import annotations

import argparse
import re
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Option:
    """An option of a command.

    Attributes
    ----------
    names : tuple of str
        Its spellings.
    about : str
        What it does, in the first sentence of its help.
    takes : bool
        Whether values follow.
    many : bool
        Whether several values may follow.
    values : tuple of str
        The values that it may have; empty for any, which are then completed as files.
    """

    names: tuple[str, ...]
    about: str
    takes: bool
    many: bool
    values: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Command:
    """A command with its options; `values` are those of its first argument, empty for files."""

    name: str
    about: str
    options: tuple[Option, ...]
    values: tuple[str, ...]


def words_of(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> tuple[Command, ...]:
    """The commands of a parser."""
    about = {action.dest: action.help or "" for action in commands._choices_actions}
    return tuple(_command(name, about.get(name, ""), parser) for name, parser in commands.choices.items())


def _command(name: str, about: str, parser: argparse.ArgumentParser) -> Command:
    seen = [action for action in parser._actions if action.help != argparse.SUPPRESS]
    named = tuple(_option(action) for action in seen if action.option_strings)
    values = next(
        (tuple(map(str, action.choices)) for action in seen if not action.option_strings and action.choices), ()
    )
    return Command(name, _sentence(about), named, values)


def _option(action: argparse.Action) -> Option:
    takes = action.nargs != 0
    values = tuple(map(str, action.choices or ()))
    return Option(tuple(action.option_strings), _sentence(action.help or ""), takes, action.nargs in ("+", "*"), values)


def _sentence(text: str) -> str:
    """The first sentence of a help text in one line, without signs that shells read."""
    first = re.split(r"(?<=[^A-Z])\. |; |: | \(", text.replace("%%", "%") + " ", maxsplit=1)[0]
    return re.sub(r"[^\w ,.%+/-]", "", " ".join(first.split())).rstrip(".")
