"""Settings of methods on the command line: ``--set METHOD.NAME=VALUE``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from cpm_core.cli.inputs.numbers import as_number
from cpm_core.objects.methods import CONTOUR_METHODS, Compared, Settings
from cpm_core.parameters import PRESETS, Parameters
from cpm_core.parameters.quotation import shown

_OURS = tuple(name for name, method in CONTOUR_METHODS.items() if method.of_particles)
"""The methods whose settings are the parameters of a run."""


def add_settings(parser: argparse._ActionsContainer) -> None:
    """Add settings, as `set`, and the preset of the particles, as `preset`; see `chosen_settings`."""
    parser.add_argument(
        "--set",
        metavar="METHOD.NAME=VALUE",
        nargs="+",
        action="extend",
        default=[],
        help="settings of methods, such as gac.balloon=0.5 cpm.smoothing=2; of "
        + "; of ".join(
            f"{name}: {', '.join(_names(name))}" for name, method in CONTOUR_METHODS.items() if not method.of_particles
        )
        + f"; of {' and '.join(_OURS)}: the parameters of cpm run",
    )
    parser.add_argument("--preset", choices=tuple(PRESETS), help=f"named settings of {' and '.join(_OURS)}")


def chosen_settings(
    arguments: argparse.Namespace, methods: Sequence[str], ours: Parameters | None, compared: Compared
) -> dict[str, Any]:
    """The settings of each of some methods: those of a comparison, `ours` of the particles if given, and what was set.

    Raises
    ------
    ValueError
        When a setting is of another form, of a method that is not compared, unknown, or out of its range.
    """
    base = PRESETS[arguments.preset] if arguments.preset else ours
    found: dict[str, Any] = {
        name: base if base is not None and CONTOUR_METHODS[name].of_particles else compared.settings_of(name)
        for name in methods
    }
    changes: dict[str, dict[str, Any]] = {}
    for text in arguments.set:
        place, equals, value = text.partition("=")
        method, dot, name = place.partition(".")
        if not (equals and dot and name and value):
            raise ValueError(f"--set is {shown(text)} but must be METHOD.NAME=VALUE, such as gac.balloon=0.5.")
        if method not in found:
            raise ValueError(f"--set {shown(text)} is for {shown(method)}, which is none of the methods compared.")
        if name not in _names(method):
            raise ValueError(f"{shown(name)} is no setting of {method}: choose among {', '.join(_names(method))}.")
        changes.setdefault(method, {})[name] = as_number(value)
    return {name: replace(settings, **changes.get(name, {})) for name, settings in found.items()}


def _names(method: str) -> tuple[str, ...]:
    """Names of the settings of a method."""
    kind = CONTOUR_METHODS[method].settings
    return tuple(kind.table()) if issubclass(kind, Settings) else tuple(Parameters.__dataclass_fields__)
