"""Completion for PowerShell."""

from __future__ import annotations

from collections.abc import Sequence

from cpm_core.cli.help.words import Command

_SCRIPT = """\
# Completion of cpm for PowerShell: cpm completion powershell | Out-String | Invoke-Expression
Register-ArgumentCompleter -Native -CommandName cpm -ScriptBlock {
    param($word, $line, $place)
    $commands = @{
%(commands)s
    }
    $values = @{
%(values)s
    }
    $given = @($line.CommandElements | ForEach-Object { $_.ToString() })
    $complete = @($given | Select-Object -Skip 1)
    if ($word -ne '') { $complete = @($complete | Select-Object -SkipLast 1) }
    if ($complete.Count -eq 0) {
        $found = $commands.Keys
    } else {
        $key = $complete[0] + ' ' + $complete[-1]
        if ($values.ContainsKey($key)) { $found = $values[$key] }
        elseif ($commands.ContainsKey($complete[0])) { $found = $commands[$complete[0]] }
        else { $found = @() }
    }
    $found | Where-Object { $_ -like "$word*" } | Sort-Object | ForEach-Object {
        [System.Management.Automation.CompletionResult]::new($_, $_, 'ParameterValue', $_)
    }
}
"""


def script(commands: Sequence[Command]) -> str:
    """The script for these commands."""
    options, values = [], []
    for command in commands:
        names = [name for option in command.options for name in option.names]
        options.append(f"        '{command.name}' = {_list(names)}")
        if command.values:
            values.append(f"        '{command.name} {command.name}' = {_list(command.values)}")
        for option in command.options:
            named = option.names if option.values else ()
            values += [f"        '{command.name} {name}' = {_list(option.values)}" for name in named]
    return _SCRIPT % {"commands": "\n".join(options), "values": "\n".join(values)}


def _list(words: Sequence[str]) -> str:
    return f"@({', '.join(repr(word) for word in words)})"
