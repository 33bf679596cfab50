"""Numbers in the text of the command line."""

from __future__ import annotations


def as_number(text: str) -> int | float | str:
    """Convert text to a number if it is one; else the check of the value reports the error."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def numbers_in(text: str) -> list[float]:
    """Numbers between commas; an empty list when a part is not a number."""
    parts = [as_number(part.strip()) for part in text.split(",")]
    numbers = [float(part) for part in parts if not isinstance(part, str)]
    return numbers if len(numbers) == len(parts) else []
