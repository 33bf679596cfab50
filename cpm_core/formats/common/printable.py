"""Names of files, contours and labels: without what a terminal or a spreadsheet would obey, and in what order."""

from __future__ import annotations

import re

from cpm_core.contours.contour import Label

_UNPRINTABLE = re.compile("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]")
"""Control characters, bytes of a name that are no UTF-8, and what XML does not allow."""

_FORMULA = ("=", "+", "-", "@")
"""Beginnings of a cell that spreadsheets compute."""

_QUOTE = "'"

_NUMBER = re.compile(r"(\d+)")


def in_natural_order(name: str) -> tuple[list[str | int], str]:
    """Key by which a2 comes before a10: numbers count by value, letters regardless of case."""
    parts = _NUMBER.split(name.casefold())
    return [int(part) if index % 2 else part for index, part in enumerate(parts)], name


def printable(text: str) -> str:
    """Text in which each character that cannot be shown is a replacement character (U+FFFD)."""
    return _UNPRINTABLE.sub("\ufffd", text)


def label_of(number: int, name: str, color: bytes) -> Label:
    """A label as a file has it: its name without what cannot be shown, and red, green and blue, or nothing."""
    return Label(number, printable(name), f"#{color.hex()}" if color else "")


def cell(text: str) -> str:
    """Text for a cell of a table, quoted where a spreadsheet would take it for a formula; see `text_of_cell`."""
    shown = printable(text)
    return _QUOTE + shown if shown.lstrip(_QUOTE).startswith(_FORMULA) else shown


def text_of_cell(content: str) -> str:
    """The text that `cell` has made a cell of."""
    return content[1:] if content.startswith(_QUOTE) and content.lstrip(_QUOTE).startswith(_FORMULA) else content
