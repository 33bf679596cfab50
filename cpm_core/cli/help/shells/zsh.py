"""Completion for zsh."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cpm_core.cli.help.words import Command, Option

_SCRIPT = """\
#compdef cpm
# Completion of cpm for zsh: eval "$(cpm completion zsh)", after compinit
_cpm() {
    local -a commands
    commands=(
%(commands)s
    )
    if (( CURRENT == 2 )); then
        _describe -t commands command commands
        _files
        return
    fi
    local command="${words[2]}"
    shift words
    (( CURRENT-- ))
    case "$command" in
%(cases)s
    esac
}
if [ "$funcstack[1]" = "_cpm" ]; then
    _cpm "$@"
else
    compdef _cpm cpm
fi
"""


def script(commands: Sequence[Command]) -> str:
    """The script for these commands."""
    named = "\n".join(f"        '{command.name}:{command.about}'" for command in commands)
    cases = "\n".join(line for command in commands for line in _case(command))
    return _SCRIPT % {"commands": named, "cases": cases}


def _case(command: Command) -> Iterator[str]:
    yield f"        {command.name})"
    yield "            _arguments -s \\"
    for option in command.options:
        for name in option.names:
            yield f"                '{'*' if option.takes else ''}{name}[{option.about}]{_values(option)}' \\"
    files = f":value:({' '.join(command.values)})" if command.values else ":file:_files"
    yield f"                '*{files}'"
    yield "            ;;"


def _values(option: Option) -> str:
    if not option.takes:
        return ""
    return f":value:({' '.join(option.values)})" if option.values else ":value:_files"
