"""Completion for bash."""

from __future__ import annotations

from collections.abc import Sequence

from cpm_core.cli.help.words import Command

_SCRIPT = """\
# Completion of cpm for bash: eval "$(cpm completion bash)"
_cpm() {
    local current="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" options="" values=""
    COMPREPLY=()
    if [ "$COMP_CWORD" -eq 1 ]; then
        COMPREPLY=($(compgen -W "%(commands)s --help --version" -- "$current") $(compgen -f -- "$current"))
        return
    fi
    case "${COMP_WORDS[1]}" in
%(cases)s
    esac
    case "${COMP_WORDS[1]} $before" in
%(values)s
    esac
    if [ -n "$values" ]; then
        COMPREPLY=($(compgen -W "$values" -- "$current"))
    elif [ "${current#-}" != "$current" ]; then
        COMPREPLY=($(compgen -W "$options" -- "$current"))
    else
        COMPREPLY=($(compgen -f -- "$current"))
    fi
}
complete -o filenames -F _cpm cpm
"""


def script(commands: Sequence[Command]) -> str:
    """The script for these commands."""
    cases, values = [], []
    for command in commands:
        names = " ".join(name for option in command.options for name in option.names)
        cases.append(f'        {command.name}) options="{names}" ;;')
        if command.values:
            values.append(f'        "{command.name} {command.name}") values="{" ".join(command.values)}" ;;')
        for option in command.options:
            if option.values:
                words = "|".join(f'"{command.name} {name}"' for name in option.names)
                values.append(f'        {words}) values="{" ".join(option.values)}" ;;')
    known = " ".join(command.name for command in commands)
    return _SCRIPT % {"commands": known, "cases": "\n".join(cases), "values": "\n".join(values)}
