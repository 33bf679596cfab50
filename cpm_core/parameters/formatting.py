"""Short texts of values: quoted in error messages, counted, and as one-line representations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches

_MAX_QUOTED_LENGTH = 40
"""Characters of a value quoted in a sentence."""

_MAX_LINE_WIDTH = 100
"""Characters of the one-line representation of an object."""


def quote_value(value: object) -> str:
    """Quote a value for a sentence: on one line, printable, at most 40 characters."""
    if isinstance(value, str):
        text = f'"{repr(value[: _MAX_QUOTED_LENGTH + 1])[1:-1]}"'
    elif isinstance(value, float):
        text = f"{value:g}"
    else:
        text = " ".join(repr(value).split())
    return text if len(text) <= _MAX_QUOTED_LENGTH else f"{text[: _MAX_QUOTED_LENGTH - 4]}…"


def suggest_name(given: str, known: Iterable[str]) -> str:
    """Ask whether a known name close to a mistyped one is meant; empty if none is close.

    >>> suggest_name("shpae", ["automatic", "shape"])
    'did you mean shape?'
    """
    near = get_close_matches(given.lower(), tuple(known), n=1)
    return f"did you mean {near[0]}?" if near else ""


def format_choice(given: str, known: Iterable[str]) -> str:
    """Format what a name must be, and which one may be meant.

    >>> format_choice("grdi", ["grid", "centers"])
    'one of grid, centers: did you mean grid?'
    """
    names = tuple(known)
    near = suggest_name(given, names)
    return f"one of {', '.join(names)}" + (f": {near}" if near else ".")


def format_repr(kind: str, *facts: str) -> str:
    """Format the one-line representation of an object: its kind, then the facts that are not empty.

    >>> format_repr("Image", "cells.png", "", "240 x 320 px")
    '<Image cells.png, 240 x 320 px>'
    """
    shown_facts = ", ".join(fact for fact in facts if fact)
    line = "".join(letter if letter.isprintable() else "?" for letter in f"{kind} {shown_facts}".strip())
    return f"<{line}>" if len(line) <= _MAX_LINE_WIDTH - 2 else f"<{line[: _MAX_LINE_WIDTH - 3]}…>"


def format_call(name: str, arguments: Sequence[str]) -> str:
    """Format a call on one line; arguments that do not fit are replaced by an ellipsis."""
    text, room = f"{name}({', '.join(arguments)})", len(arguments)
    while len(text) > _MAX_LINE_WIDTH:
        room -= 1
        text = f"{name}({', '.join(arguments[:room])}, …)"
    return text


def format_count(count: int, one: str, several: str = "") -> str:
    """Format a count with its noun: ``"1 contour"``, ``"2 contours"``."""
    return f"{count:,} {one if count == 1 else several or one + 's'}"


def format_size(shape: tuple[int, ...], unit: str = "px") -> str:
    """Format a shape: ``"240 x 320 px"``."""
    return f"{' x '.join(map(str, shape))} {unit}".strip()
