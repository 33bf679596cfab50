"""Parser of the command line: help on one screen, the rest by ``--help all``, and what a mistyped word may mean."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

from cpm_core.parameters.formatting import format_choice, quote_value, suggest_name

_ALL = "all"
"""Value of ``--help`` for all options."""


class _Formatter(argparse.RawDescriptionHelpFormatter):
    """Help whose first line has only what a command cannot do without."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, max_help_position=28)

    def add_usage(
        self, usage: str | None, actions: Iterable[argparse.Action], groups: Iterable[Any], prefix: str | None = None
    ) -> None:
        needed = [action for action in actions if action.required or not action.option_strings]
        super().add_usage(usage, needed, (), prefix)


class _HelpAction(argparse.Action):
    """Print the usual options, each in a sentence, or all of them in full."""

    def __call__(self, parser: argparse.ArgumentParser, _: object, values: object, __: str | None = None) -> None:
        if values != _ALL and isinstance(parser, CliParser):
            parser.keep_usual_options()
        print(parser.format_help(), end="")  # argparse would hide that it cannot be written
        parser.exit()


class CliParser(argparse.ArgumentParser):
    """Parser that raises ValueError, which `main` reports.

    Parameters
    ----------
    usual : str
        Options on the first screen of the help, between spaces; all of them if empty.
    **settings
        Those of `argparse.ArgumentParser`.
    """

    def __init__(self, usual: str = "", **settings: Any) -> None:
        super().__init__(**{"formatter_class": _Formatter, "allow_abbrev": False, "add_help": False, **settings})
        self._usual = {f"--{name}" for name in usual.split()}
        self._whole_help = f"--help {_ALL}" if usual else "--help"
        what = f"Show this help; {self._whole_help} has all options in full." if usual else "Show this help."
        takes_all: dict[str, Any] = {"nargs": "?", "metavar": _ALL} if usual else {"nargs": 0}
        self.add_argument("-h", "--help", action=_HelpAction, help=what, **takes_all)
        # argparse would take -50,-50,3, -1e-3 and -.csv for options
        self._negative_number_matcher = re.compile(r"-(?:\.?\d|\.\w|inf|nan)", re.IGNORECASE)

    def keep_usual_options(self) -> None:
        """Keep only the first sentence of the usual options in the help."""
        for action in self._actions if self._usual else ():
            flags = action.option_strings
            if flags and not {"--help", *self._usual} & {*flags}:
                action.help = argparse.SUPPRESS
            elif "--help" not in flags:
                action.help = f"{(action.help or '').partition('. ')[0].rstrip('.')}."
        for group in self._action_groups:
            group.description = None

    def parse_command(self, arguments: Sequence[str]) -> argparse.Namespace:
        """Parse the arguments of a command; ValueError when they are wrong."""
        commands: Any = next(action for action in self._actions if action.choices)
        named = commands.choices.get(arguments[0]) if arguments else None
        (named or self)._check_option_names(arguments)
        parsed, rest = self.parse_known_args(arguments)
        if rest:
            raise ValueError(f"{quote_value(rest[0])} is one argument too many: see {self.prog} {parsed.name} --help.")
        return parsed

    def _check_option_names(self, arguments: Sequence[str]) -> None:
        """Raise ValueError for the first option that there is none of."""
        for text in arguments:
            name = text.partition("=")[0]
            if name == "--":
                return
            if name.startswith("--") and name not in self._option_string_actions:
                near = suggest_name(name, self._option_string_actions)
                raise ValueError(f"{self.prog} has no option {name}: {near or f'see {self.prog} {self._whole_help}.'}")

    def error(self, message: str) -> NoReturn:
        """Raise ValueError with a message of argparse."""
        raise ValueError(f"{message.removeprefix('argument ')}. See {self.prog} --help.")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            name = next(iter(action.option_strings), action.metavar or action.dest)
            raise ValueError(f"{name} is {quote_value(value)} but must be {format_choice(value, action.choices)}")
