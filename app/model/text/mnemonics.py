"""Mnemonics: the letters behind ``&`` that choose the entries of a menu, made distinct within it."""

from __future__ import annotations

import re
from collections.abc import Sequence

_MARK = re.compile(r"&([^\W_])")
"""The mark of a mnemonic; two marks stand for the character itself."""


def mnemonic_of(text: str) -> str:
    """The letter that chooses an entry, in lower case; empty where there is none."""
    found = _MARK.search(text.replace("&&", "\0\0"))
    return found[1].lower() if found else ""


def distinct(texts: Sequence[str]) -> list[str]:
    """The entries of a menu, none of which has the mnemonic of another one.

    The first one with a letter keeps it. Another one gets a letter that none has asked for, where possible that of the
    beginning of a word, or none at all.
    """
    taken: set[str] = set()
    kept: list[bool] = []
    for text in texts:
        letter = mnemonic_of(text)
        kept.append(letter not in taken)
        taken |= {letter} - {""}
    return [text if keeps else _moved(text, taken) for text, keeps in zip(texts, kept, strict=True)]


def _moved(text: str, taken: set[str]) -> str:
    """An entry with another mnemonic, which is taken from then on."""
    plain = text.replace("&&", "\0\0").replace("&", "")
    first = [found.start() for found in re.finditer(r"\b[^\W_]", plain)]
    others = [found.start() for found in re.finditer(r"[^\W_]", plain) if found.start() not in first]
    place = next((at for at in (*first, *others) if plain[at].lower() not in taken), None)
    if place is not None:
        taken.add(plain[place].lower())
        plain = f"{plain[:place]}&{plain[place:]}"
    return plain.replace("\0\0", "&&")
