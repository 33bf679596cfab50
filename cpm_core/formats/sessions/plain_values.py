"""Values of a session as plain JSON and back: shapes, parameters, and any frozen dataclass by the types of its fields.

Dataclasses may hold numbers, text, truth values, literals, tuples and dataclasses of them: all that shapes are made of.
What comes back has been checked against the types; whatever does not fit leads to one sentence.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from cpm_core.parameters import FORMER_NAMES, Parameters
from cpm_core.shapes import SHAPES, Everywhere, Kind, Shape

T = TypeVar("T")

LARGEST = 1e6
"""Largest number of a session file, either way: far outside of any image, and no sum of such numbers overflows."""

_FORMER_KINDS: Mapping[object, Kind] = MappingProxyType({"edges": "gradient"})
"""Kinds of starts everywhere by the names that older files have for them."""


def to_plain(value: object) -> Any:
    """A value of a dataclass, or one itself, as JSON keeps it."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple | list):
        return [to_plain(item) for item in value]
    if isinstance(value, bool | str | int) or value is None:
        return value
    return float(value)  # type: ignore[arg-type]  # numbers of NumPy as well


def from_plain(kind: type[T], plain: object, where: str) -> T:
    """A dataclass from what JSON has kept of it.

    Parameters
    ----------
    kind : type
        Which dataclass.
    plain : object
        What was read: a mapping of its fields; those with a default may be missing.
    where : str
        What it is called in a sentence on what is wrong, as in ``"shape 3"``.

    Raises
    ------
    ValueError
        When something is missing, unknown, or not of its type; and whatever the dataclass itself finds wrong.
    """
    plain = mapping(plain, where)
    hints = get_type_hints(kind)
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    unknown = sorted(str(name) for name in plain if name not in fields)
    if unknown:
        raise ValueError(f"{where} has a value {shown(unknown[0])}, but only {', '.join(fields)} are known.")
    given: dict[str, Any] = {}
    for name, field in fields.items():
        if name in plain:
            given[name] = _value(hints[name], plain[name], f"{name} of {where}")
        elif field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING:
            raise ValueError(f"{where} has no {name}.")
    try:
        return kind(**given)
    except ValueError as error:
        raise ValueError(f"{where} cannot be used: {error}") from error


def shape_to_plain(shape: Shape) -> dict[str, Any]:
    """A shape as JSON keeps it: its kind and the values of its fields."""
    kind = next(name for name, made in SHAPES.items() if type(shape) is made)
    return {"shape": kind, **to_plain(shape)}


def shape_from_plain(plain: object, where: str) -> Shape:
    """A shape from what JSON has kept of it; ValueError when it is none, or none that could be drawn."""
    values = dict(mapping(plain, where))
    kind = values.pop("shape", None)
    if not isinstance(kind, str) or kind not in SHAPES:
        raise ValueError(f"{where} is of the kind {shown(kind)} but must be one of {', '.join(SHAPES)}.")
    if SHAPES[kind] is Everywhere and values.get("kind") in _FORMER_KINDS:
        values["kind"] = _FORMER_KINDS[values["kind"]]
    return from_plain(SHAPES[kind], values, f"{where} ({kind})")


def parameters_from_plain(plain: object) -> tuple[Parameters, tuple[str, ...]]:
    """Parameters from what JSON has kept of them, under their present or former names.

    Returns
    -------
    parameters : Parameters
        Those that are missing have their defaults.
    unknown : tuple of str
        Names that are none of a parameter.

    Raises
    ------
    ValueError
        When `plain` is no mapping, or a value lies outside its range.
    """
    given = {FORMER_NAMES.get(name, name): value for name, value in mapping(plain, "parameters").items()}
    known = {field.name for field in dataclasses.fields(Parameters)}
    values = {name: value for name, value in given.items() if name in known}
    for name, value in values.items():
        if not isinstance(value, str):
            number(value, name, 1e9)
    if isinstance(values.get("scales"), float) and values["scales"] == int(values["scales"]):
        values["scales"] = int(values["scales"])
    return Parameters(**values), tuple(sorted(set(given) - known))


def mapping(value: object, where: str) -> Mapping[str, Any]:
    """An object with named values, else ValueError."""
    if not isinstance(value, Mapping):
        raise ValueError(f"{where} is {shown(value)} but must be an object with named values.")
    return value


def shown(value: object) -> str:
    """A value as it stands in a sentence: short, whatever it is."""
    text = f'"{value}"' if isinstance(value, str) else repr(value)
    return text if len(text) <= 40 else f"{text[:36]}…"


def number(value: object, where: str, largest: float = LARGEST) -> float:
    """A finite number that is not too large, else ValueError."""
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= largest:
        return float(value)
    raise ValueError(f"{where} is {shown(value)} but must be a number from {-largest:g} to {largest:g}.")


def _value(hint: Any, plain: object, where: str) -> Any:
    origin = get_origin(hint)
    if origin is tuple:
        return _tuple(get_args(hint), plain, where)
    if origin is Literal:
        if plain not in get_args(hint) or isinstance(plain, bool):
            allowed = ", ".join(shown(item) for item in get_args(hint))
            raise ValueError(f"{where} is {shown(plain)} but must be one of {allowed}.")
        return plain
    if hint is float:
        return number(plain, where)
    if hint is int:
        if number(plain, where) != math.floor(number(plain, where)):
            raise ValueError(f"{where} is {shown(plain)} but must be a whole number.")
        return int(number(plain, where))
    if hint in (str, bool):
        if not isinstance(plain, hint):
            raise ValueError(f"{where} is {shown(plain)} but must be {'text' if hint is str else 'true or false'}.")
        return plain
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return from_plain(hint, plain, where)
    raise TypeError(f"{where} is of the type {hint}, which session files cannot keep")


def _tuple(items: tuple[Any, ...], plain: object, where: str) -> tuple[Any, ...]:
    if not isinstance(plain, list):
        raise ValueError(f"{where} is {shown(plain)} but must be a list.")
    if len(items) == 2 and items[1] is Ellipsis:
        return tuple(_value(items[0], item, where) for item in plain)
    if len(plain) != len(items):
        raise ValueError(f"{where} is {shown(plain)} but must be a list of {len(items)} values.")
    return tuple(_value(hint, item, where) for hint, item in zip(items, plain, strict=True))
