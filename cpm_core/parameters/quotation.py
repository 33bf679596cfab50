"""Quotation: a value as it stands in the sentence that refuses it."""

from __future__ import annotations

_LONGEST = 40


def shown(value: object) -> str:
    """A value as text for a sentence: on one line, printable, of 40 characters at most."""
    if isinstance(value, str):
        text = f'"{repr(value[: _LONGEST + 1])[1:-1]}"'
    elif isinstance(value, float):
        text = f"{value:g}"
    else:
        text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 4]}…"
