"""Quotation: a value as it appears in the sentence that refuses it, and an object on the one line that shows it."""

from __future__ import annotations

from collections.abc import Sequence

_LONGEST = 40
_WIDEST = 100
"""Letters of the line that shows an object."""


def shown(value: object) -> str:
    """A value as text for a sentence: on one line, printable, of 40 characters at most."""
    if isinstance(value, str):
        text = f'"{repr(value[: _LONGEST + 1])[1:-1]}"'
    elif isinstance(value, float):
        text = f"{value:g}"
    else:
        text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 4]}…"


def described(kind: str, *facts: str) -> str:
    """The line by which an object is shown in Python: its kind, and the facts that are not empty.

    >>> described("Image", "cells.png", "", "240 x 320 px")
    '<Image cells.png, 240 x 320 px>'
    """
    shown_facts = ", ".join(fact for fact in facts if fact)
    line = "".join(letter if letter.isprintable() else "?" for letter in f"{kind} {shown_facts}".strip())
    return f"<{line}>" if len(line) <= _WIDEST - 2 else f"<{line[: _WIDEST - 3]}…>"


def call(name: str, arguments: Sequence[str]) -> str:
    """A call on one line; the arguments that have no room are left out, which is marked."""
    text, room = f"{name}({', '.join(arguments)})", len(arguments)
    while len(text) > _WIDEST:
        room -= 1
        text = f"{name}({', '.join(arguments[:room])}, …)"
    return text


def counted(count: int, one: str, several: str = "") -> str:
    """A number of things in words: ``"1 contour"``, ``"2 contours"``."""
    return f"{count:,} {one if count == 1 else several or one + 's'}"


def sized(shape: tuple[int, ...], unit: str = "px") -> str:
    """Numbers of rows and columns in words: ``"240 x 320 px"``."""
    return f"{' x '.join(map(str, shape))} {unit}".strip()
