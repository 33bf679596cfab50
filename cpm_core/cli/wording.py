"""Words that several commands use."""

from __future__ import annotations


def counted(number: int, noun: str) -> str:
    """Number and noun, as in "1 contour" and "2 contours"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
