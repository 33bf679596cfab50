"""Values of a session as plain JSON and back: shapes, parameters, and any frozen dataclass by the types of its fields.

Dataclasses may hold numbers, text, truth values, literals, tuples and dataclasses of them: all that shapes consist of.
Values that are read are checked against the types; one that does not fit raises ValueError with one sentence.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from cpm_core.parameters import Parameters
from cpm_core.parameters.quotation import shown
from cpm_core.shapes import SHAPES, Everywhere, Kind, Shape

T = TypeVar("T")

LARGEST = 1e6
"""Largest absolute value of a number: far outside of any image, and sums of such numbers do not overflow."""

_FORMER_KINDS: Mapping[object, Kind] = MappingProxyType({"edges": "gradient"})
"""Names of automatic starts in older files -> present names."""


def to_plain(value: object) -> Any:
    """A dataclass, or the value of one of its fields, as plain JSON."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: to_plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple | list):
        return [to_plain(item) for item in value]
    if isinstance(value, bool | str | int) or value is None:
        return value
    return float(value)  # type: ignore[arg-type]  # numbers of NumPy as well


def from_plain(kind: type[T], plain: object, where: str) -> T:
    """A dataclass of type `kind` from a mapping of its fields; those with a default may be missing.

    ValueError when a field is missing, unknown, or not of its type, or the dataclass rejects a value; `where` names the
    dataclass in the sentence, as in ``"shape 3"``.
    """
    plain = mapping(plain, where)
    hints = get_type_hints(kind, include_extras=True)
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
    """A shape as plain JSON: its kind and the values of its fields."""
    kind = next(name for name, made in SHAPES.items() if type(shape) is made)
    return {"shape": kind, **to_plain(shape)}


def shape_from_plain(plain: object, where: str) -> Shape:
    """A shape from plain JSON; ValueError when it is not a valid shape."""
    values = dict(mapping(plain, where))
    kind = values.pop("shape", None)
    if not isinstance(kind, str) or kind not in SHAPES:
        raise ValueError(f"{where} is of the kind {shown(kind)} but must be one of {', '.join(SHAPES)}.")
    former = values.get("kind")
    if SHAPES[kind] is Everywhere and isinstance(former, str) and former in _FORMER_KINDS:
        values["kind"] = _FORMER_KINDS[former]
    return from_plain(SHAPES[kind], values, f"{where} ({kind})")


def parameters_from_plain(plain: object) -> tuple[Parameters, tuple[str, ...]]:
    """Parameters from plain JSON under their present or former names, and the names that are unknown.

    Missing parameters have their defaults. ValueError when `plain` is not a mapping, or a value is out of range.
    """
    given = dict(mapping(plain, "parameters"))
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


def number(value: object, where: str, largest: float = LARGEST) -> float:
    """A finite number that is not too large, else ValueError."""
    if isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= largest:
        return float(value)
    raise ValueError(f"{where} is {shown(value)} but must be a number from {-largest:g} to {largest:g}.")


def true_or_false(value: object, where: str) -> bool:
    """A truth value, else ValueError."""
    if not isinstance(value, bool):
        raise ValueError(f"{where} is {shown(value)} but must be true or false.")
    return value


def _value(hint: Any, plain: object, where: str) -> Any:
    origin = get_origin(hint)
    if origin is Annotated:
        return _position(get_args(hint), plain, where)
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
    raise TypeError(f"{where} is of the type {hint}, which session files cannot store")


def _position(kind: tuple[Any, ...], plain: object, where: str) -> tuple[Any, ...]:
    """A tuple of as many numbers as its annotation allows."""
    found: tuple[Any, ...] = _value(kind[0], plain, where)
    if len(found) not in kind[1:]:
        raise ValueError(f"{where} is {shown(plain)} but must be a list of {' or '.join(map(str, kind[1:]))} values.")
    return found


def _tuple(items: tuple[Any, ...], plain: object, where: str) -> tuple[Any, ...]:
    if not isinstance(plain, list):
        raise ValueError(f"{where} is {shown(plain)} but must be a list.")
    if len(items) == 2 and items[1] is Ellipsis:
        return tuple(_value(items[0], item, where) for item in plain)
    if len(plain) != len(items):
        raise ValueError(f"{where} is {shown(plain)} but must be a list of {len(items)} values.")
    return tuple(_value(hint, item, where) for hint, item in zip(items, plain, strict=True))
