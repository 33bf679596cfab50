"""Names of files, contours and labels: made safe for terminals and spreadsheets, and sorted naturally."""

from __future__ import annotations

import re

from cpm_core.image.surface import Label

_UNPRINTABLE_CHARACTERS = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
"""Control characters, bytes that are not valid UTF-8, and characters that XML forbids."""

_FORMULA_STARTS = ("=", "+", "-", "@")
"""First characters of a cell that a spreadsheet would evaluate."""

_QUOTE_MARK = "'"
"""Prefix that keeps a spreadsheet from evaluating a cell."""

_DIGIT_RUN = re.compile(r"(\d+)")


def natural_sort_key(name: str) -> tuple[list[str | int], str]:
    """Return a sort key that puts a2 before a10: numbers compare by value, letters regardless of case."""
    parts = _DIGIT_RUN.split(name.casefold())
    return [int(part) if index % 2 else part for index, part in enumerate(parts)], name


def make_printable(text: str) -> str:
    """Replace each character that cannot be shown by the replacement character (U+FFFD)."""
    return _UNPRINTABLE_CHARACTERS.sub("\ufffd", text)


def build_label(number: int, name: str, color: bytes) -> Label:
    """Build a label from a file: its name made printable, and its color from red, green and blue bytes or none."""
    return Label(number, make_printable(name), f"#{color.hex()}" if color else "")


def escape_cell(text: str) -> str:
    """Make text safe for a table cell: quoted if a spreadsheet would take it for a formula; see `unescape_cell`."""
    shown = make_printable(text)
    return _QUOTE_MARK + shown if shown.lstrip(_QUOTE_MARK).startswith(_FORMULA_STARTS) else shown


def unescape_cell(content: str) -> str:
    """Undo `escape_cell`."""
    return (
        content[1:]
        if content.startswith(_QUOTE_MARK) and content.lstrip(_QUOTE_MARK).startswith(_FORMULA_STARTS)
        else content
    )
