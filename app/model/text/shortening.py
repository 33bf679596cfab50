"""Texts from outside that are too long to be shown: of a million letters the layout alone would take minutes."""

from __future__ import annotations

MOST_SHOWN = 4000
"""Letters of a text that are shown: more than any path of a file has."""


def shortened(text: str, most: int = MOST_SHOWN) -> str:
    """A text of at most `most` letters: the middle of a longer one is left out."""
    if len(text) <= most:
        return text
    half = (most - 1) // 2
    return f"{text[:half]}…{text[-half:]}"
