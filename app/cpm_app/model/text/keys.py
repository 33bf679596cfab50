"""Keys in texts: shortcuts named in sentences, as the user has set them, and mnemonics of menu entries.

A sentence names a key by its action, as in ``"Press {key:run} to run."`` or ``"Open an image ({key:open})."``, also in
its translations. `insert_keys` puts the keys in; the window fills the table by `use_action_names`, and again after each
change.

Mnemonics are underlined in menus and written after ``&``; no menu has the same one twice. Translators cannot see which
entries end up in one menu, and many entries are hidden for some kinds of files. So each sentence comes with the letter
that suits it, and where two entries of a menu have the same, the later one gets another.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from string import ascii_uppercase
from typing import NamedTuple


class ActionName(NamedTuple):
    """Key and title of an action in sentences; the key is as the platform writes it, empty if there is none."""

    key: str
    title: str


_names: Mapping[str, ActionName] = {}

_KEY_IN_PARENTHESES = re.compile(r" \(\{key:(\w+)\}\)")
"""A key that a sentence names in parentheses."""


class _Keys:
    """Placeholder that is formatted as the key of the action that the format names."""

    def __format__(self, action: str) -> str:
        return key_or_title(action)


def use_action_names(names: Mapping[str, ActionName]) -> None:
    """Set the keys and titles of actions for sentences, by the names of the actions in code."""
    global _names  # noqa: PLW0603  # as the language, it holds for all sentences of the program
    _names = dict(names)


def key_or_title(action: str) -> str:
    """Return the key of an action or, if it has none, its title in quotation marks, as in the menus."""
    named = _names.get(action, ActionName("", action))
    return named.key or f"“{named.title}”"


def insert_keys(sentence: str, **values: object) -> str:
    """Fill in the keys of actions in a sentence, and the values of everything else in braces.

    An action without a key is called by its title; a key in parentheses after the title is then left out.
    """

    def keep_if_assigned(found: re.Match[str]) -> str:
        return found[0] if found[1] in _names and _names[found[1]].key else ""

    return _KEY_IN_PARENTHESES.sub(keep_if_assigned, sentence).format(key=_Keys(), **values)


_MNEMONIC_PATTERN = re.compile(r"&&|&(\w)")
"""A mnemonic, or an ampersand that is written twice."""

_APPENDED_MNEMONIC = re.compile(r"\(&\w\)")
"""A mnemonic after the text, as in languages without an alphabet: ``終了(&Q)``."""


def make_mnemonics_unique(texts: Sequence[str]) -> list[str]:
    """Return the texts with unique mnemonics; a text keeps its letter unless an earlier one has the same.

    Parameters
    ----------
    texts : sequence of str
        Texts of the entries, in their order. An entry without a mark gets none.
    """
    own, taken, made = set(map(find_mnemonic, texts)), {""}, []
    for text in texts:
        kept = text
        if "" != find_mnemonic(text) in taken:
            kept = next(
                (other for other in _mark_other_letters(text) if find_mnemonic(other) not in own | taken),
                _remove_mnemonic(text),
            )
        taken.add(find_mnemonic(kept))
        made.append(kept)
    return made


def find_mnemonic(text: str) -> str:
    """Return the mnemonic of a text as a capital; empty when it has none."""
    return next((found[1].upper() for found in _MNEMONIC_PATTERN.finditer(text) if found[1]), "")


def _mark_other_letters(text: str) -> Iterator[str]:
    """Yield the text with other letters marked: first those that begin a word, then the rest."""
    if _APPENDED_MNEMONIC.search(text):
        yield from (_APPENDED_MNEMONIC.sub(f"(&{letter})", text) for letter in ascii_uppercase)
        return
    bare = _remove_mnemonic(text)
    begins = [found.start() for found in re.finditer(r"\b[^\W\d_]", bare)]
    within = [place for place, sign in enumerate(bare) if sign.isalpha() and place not in begins]
    yield from (f"{bare[:place]}&{bare[place:]}" for place in [*begins, *within])


def _remove_mnemonic(text: str) -> str:
    """Return the text without its mnemonic; ``&&`` is the sign itself and stays."""
    bare = _APPENDED_MNEMONIC.sub("", text)
    return _MNEMONIC_PATTERN.sub(lambda found: found[1] or "&&", bare)
