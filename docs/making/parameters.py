"""The table of parameters, from the descriptions that the window and the command line use."""

from __future__ import annotations

from cpm_core.parameters import DEFAULT_VALUES, PARAMETERS, PRESETS, ParameterInfo
from cpm_core.parameters.choices import CHOICE_PARAMETERS
from docs.making.tables import table as made

_STALE = {
    "nothing": "acts at the next step",
    "contours": "contours alone",
    "field": "field",
    "run": "whole run",
}
"""What is computed again after a change."""


def table_line(info: ParameterInfo) -> tuple[str, ...]:
    """Return the row of a parameter that is a number."""
    unit = f" {info.unit}" if info.unit else ""
    default = DEFAULT_VALUES[info.name]
    allowed = f"{info.low:g} or more" if info.high >= 1e9 else f"{info.low:g} to {info.high:g}"
    value = default if isinstance(default, str) else f"{default:g}{unit}"
    meaning = f"**{info.title}.** {info.meaning} {info.effect_of_larger}" + (
        f" ({info.equation})" if info.equation else ""
    )
    return f"`{info.name}`", info.symbol, value, allowed, meaning, _STALE[info.invalidates]


def table_of_choices() -> str:
    """All parameters that are choices."""
    lines = []
    for name, choice in CHOICE_PARAMETERS.items():
        values = "<br>".join(f"`{value}`: {what}" for value, what in choice.choices.items())
        lines.append((f"`{name}`", f"`{DEFAULT_VALUES[name]}`", f"**{choice.title}.** {choice.meaning}", values))
    return made(("name", "default", "what it does", "values"), lines)


def table() -> str:
    """All parameters: first those that are numbers."""
    heads = ("name", "symbol", "default", "allowed", "what it does", "a change needs")
    return f"{made(heads, (table_line(info) for info in PARAMETERS.values()))}\n{table_of_choices()}"


def presets() -> str:
    """Tabulate the named settings by what differs from the defaults."""
    lines = ((f"`{name}`", f"`{preset}`") for name, preset in PRESETS.items())
    return made(("name", "settings that differ from the defaults"), lines)
