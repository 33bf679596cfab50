"""Completion for fish."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cpm_core.cli.help.words import Command


def script(commands: Sequence[Command]) -> str:
    """The script for these commands."""
    return "\n".join(["# Completion of cpm for fish: cpm completion fish | source", *_lines(commands)]) + "\n"


def _lines(commands: Sequence[Command]) -> Iterator[str]:
    first = "__fish_use_subcommand"
    yield f"complete -c cpm -n {first} -l help -d 'show the help'"
    yield f"complete -c cpm -n {first} -l version -d 'show the version'"
    for command in commands:
        yield f"complete -c cpm -n {first} -a {command.name} -d '{command.about}'"
        within = f"'__fish_seen_subcommand_from {command.name}'"
        if command.values:
            yield f"complete -c cpm -f -n {within} -a '{' '.join(command.values)}'"
        for option in command.options:
            names = " ".join(f"-l {name[2:]}" if name.startswith("--") else f"-s {name[1:]}" for name in option.names)
            takes = (" -x -a '" + " ".join(option.values) + "'") if option.values else " -r -F" if option.takes else ""
            yield f"complete -c cpm -n {within} {names}{takes} -d '{option.about}'"
