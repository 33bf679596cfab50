"""Frozen dataclasses as plain JSON and back, by the types of their fields.

It knows numbers, text, truth values, literals, tuples and dataclasses of them: all that shapes are made of. What comes
back has been checked against the types; whatever does not fit leads to one sentence.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

T = TypeVar("T")

LARGEST = 1e6
"""Largest number of a session file, either way: far outside of any image, and no sum of such numbers overflows."""


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
    if not isinstance(plain, Mapping):
        raise ValueError(f"{where} is {shown(plain)} but must be an object with named values.")
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
    return kind(**given)


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
