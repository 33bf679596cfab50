"""Group codes of DXF: the pairs of a drawing, by sections and entries."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from cpm_core.formats.images.decoded import UnreadableError

Pair = tuple[int, str]

_BINARY = b"AutoCAD Binary DXF"
_LETTER = re.compile(r"\\U\+([0-9A-Fa-f]{4})")


@dataclass(frozen=True, slots=True)
class Entry:
    """An entity, or an entry of a table: its kind and its pairs of code and value."""

    kind: str
    pairs: tuple[Pair, ...]

    def text(self, code: int, otherwise: str = "") -> str:
        """The first value of a code."""
        return next((_LETTER.sub(_decoded, value) for known, value in self.pairs if known == code), otherwise)

    def number(self, code: int, otherwise: float = 0.0) -> float:
        """The first value of a code as a number."""
        return next((float(value) for known, value in self.pairs if known == code), otherwise)

    def numbers(self, code: int) -> list[float]:
        """All values of a code as numbers."""
        return [float(value) for known, value in self.pairs if known == code]


def _decoded(found: re.Match[str]) -> str:
    return chr(int(found[1], 16))


def decoded(content: bytes) -> str:
    """The text of a drawing; the code page of old ones is taken to be that of western Europe."""
    if content.startswith(_BINARY):
        raise UnreadableError("The drawing is binary DXF: save it as ASCII DXF.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("cp1252", errors="replace")


def comments_of(text: str) -> dict[str, str]:
    """Comments at the beginning, as names and texts."""
    found: dict[str, str] = {}
    name = ""
    for code, value in _pairs(text):
        if code != 999:
            break
        if value.startswith("  ") and name:
            found[name] += " " + value.strip()
        elif ": " in value:
            name, _, told = value.partition(": ")
            found[name] = told
    return found


def sections_of(text: str) -> dict[str, list[Entry]]:
    """The entries of each section by its name; in the header each variable is one."""
    sections: dict[str, list[Entry]] = {}
    entries: list[Entry] | None = None
    kind, pairs = "", list[Pair]()
    name_follows = False
    for code, value in _pairs(text):
        begins = code == 0 or (code == 9 and entries is not None)
        if begins:
            if entries is not None and kind:
                entries.append(Entry(kind, tuple(pairs)))
            kind, pairs = value, []
            name_follows = value == "SECTION"
            if value in ("SECTION", "ENDSEC", "EOF"):
                entries, kind = None, ""
        elif name_follows and code == 2:
            entries = sections.setdefault(value, [])
            name_follows = False
        else:
            pairs.append((code, value))
    if not sections:
        raise ValueError("no sections")
    return sections


def _pairs(text: str) -> Iterator[Pair]:
    lines = iter(text.splitlines())
    for code in lines:
        value = next(lines, None)
        if value is None:
            return
        yield int(code), value.rstrip("\r\n") if code.strip() == "999" else value.strip()
