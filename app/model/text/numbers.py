"""Numbers in the texts of the window, with the marks of its language."""

from __future__ import annotations

_marks: dict[int, str] = {}


def use_marks(decimal: str, group: str) -> None:
    """Write numbers with a decimal mark, and with a separator of groups of three digits."""
    global _marks  # noqa: PLW0603  # a language is chosen once, at the start
    _marks = str.maketrans({".": decimal, ",": group})


def written(number: str) -> str:
    """A number that Python has formatted, as the language of the window writes it."""
    return number.translate(_marks)
