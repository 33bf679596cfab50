"""The comparison of methods in a session file."""

from __future__ import annotations

from typing import Any

from cpm_core.formats.sessions.plain_values import mapping, to_plain, true_or_false
from cpm_core.objects.methods import CONTOUR_METHODS, Compared, Settings
from cpm_core.parameters.quotation import shown


def compared_to_plain(compared: Compared) -> dict[str, Any]:
    """A comparison as plain JSON."""
    settings = {name: to_plain(chosen) for name, chosen in compared.settings}
    return {"methods": list(compared.methods), "settings": settings, "around": compared.around}


def compared_from_plain(plain: object, faults: list[str]) -> Compared:
    """A comparison from plain JSON; what cannot be used is left out, and a sentence on it added to the faults."""
    try:
        given = mapping(plain, "comparison")
        around = true_or_false(given.get("around", False), "around of the comparison")
        methods = given.get("methods", [])
        if not isinstance(methods, list) or not all(isinstance(name, str) for name in methods):
            raise ValueError(f"methods of the comparison is {shown(methods)} but must be a list of names.")
        listed = mapping(given.get("settings", {}), "settings of the comparison")
    except ValueError as error:
        faults.append(f"The comparison of methods was left out: {error}")
        return Compared()
    unknown = sorted(({*methods, *listed} - {""}) - set(CONTOUR_METHODS))
    if unknown:
        faults.append(f"Methods that are not known here were left out: {shown(', '.join(unknown))}.")
    names = [name for name in methods if name in CONTOUR_METHODS]
    chosen = {name: _settings(name, values, faults) for name, values in listed.items() if name in CONTOUR_METHODS}
    return Compared(tuple(names), tuple((name, one) for name, one in chosen.items() if one is not None), around)


def _settings(method: str, plain: object, faults: list[str]) -> Settings | None:
    """The settings of a method; None where they cannot be used or are its defaults."""
    kind = CONTOUR_METHODS[method].settings
    try:
        if not issubclass(kind, Settings):
            raise ValueError("it has the parameters of the run.")
        values = mapping(plain, f"settings of {method}")
        strange = sorted(set(values) - set(kind.table()))
        if strange:
            raise ValueError(f"it has no {shown(strange[0])}.")
        found = kind(**values)
    except ValueError as error:
        faults.append(f"The settings of {method} in the comparison were left out: {error}")
        return None
    return None if found == kind() else found
