"""Keys in texts: those of actions in sentences, as the user has set them, and the letters that choose entries of menus.

A sentence names a key by its action, as in ``"Press {key:run} to run."`` or ``"Open an image ({key:open})."``, also in
its translations. `with_keys` puts the keys in; the window fills the table by `use_names`, and again after each change.

Letters of menus are underlined and written after ``&``: each once in a menu. Translators cannot see which entries end
up in one menu, and many of them are hidden for one kind of file or another. So each sentence comes with the letter that
suits it, and where two of a menu come with the same, the later one gets another letter of its own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from string import ascii_uppercase
from typing import NamedTuple


class Named(NamedTuple):
    """An action in sentences: its key as people call it here, empty if it has none, and its title."""

    key: str
    title: str


_names: Mapping[str, Named] = {}

_IN_PARENTHESES = re.compile(r" \(\{key:(\w+)\}\)")


class _Keys:
    """Is formatted as the key of the action that the format names."""

    def __format__(self, action: str) -> str:
        return key_of(action)


def use_names(names: Mapping[str, Named]) -> None:
    """Set what actions are called in sentences, by their names in code."""
    global _names  # noqa: PLW0603  # as the language, it holds for all sentences of the program
    _names = dict(names)


def key_of(action: str) -> str:
    """The key of an action; its title in quotation marks, by which it is found in the menus, if it has no key."""
    named = _names.get(action, Named("", action))
    return named.key or f"“{named.title}”"


def with_keys(said: str, **values: object) -> str:
    """A sentence with the keys of actions, and with the values of what else is in braces.

    An action without a key is called by its title; in parentheses, behind its title, it is left out.
    """

    def behind(found: re.Match[str]) -> str:
        return found[0] if found[1] in _names and _names[found[1]].key else ""

    return _IN_PARENTHESES.sub(behind, said).format(key=_Keys(), **values)


_MARK = re.compile(r"&&|&(\w)")

_APART = re.compile(r"\(&\w\)")
"""A letter behind the text, as in languages that are not written in letters: ``終了(&Q)``."""


def distinct(texts: Sequence[str]) -> list[str]:
    """The texts, with no letter marked in two of them; a text keeps its letter unless one before it has the same.

    Parameters
    ----------
    texts : sequence of str
        Texts of the entries, in their order. An entry without a mark gets none.
    """
    own, taken, made = set(map(letter_of, texts)), {""}, []
    for text in texts:
        kept = text
        if "" != letter_of(text) in taken:
            kept = next((other for other in _others(text) if letter_of(other) not in own | taken), _without(text))
        taken.add(letter_of(kept))
        made.append(kept)
    return made


def letter_of(text: str) -> str:
    """The letter that a text marks, as a capital; empty when there is none."""
    return next((found[1].upper() for found in _MARK.finditer(text) if found[1]), "")


def _others(text: str) -> Iterator[str]:
    """The text with other letters marked: first those that begin a word, then the rest."""
    if _APART.search(text):
        yield from (_APART.sub(f"(&{letter})", text) for letter in ascii_uppercase)
        return
    bare = _without(text)
    begins = [found.start() for found in re.finditer(r"\b[^\W\d_]", bare)]
    within = [place for place, sign in enumerate(bare) if sign.isalpha() and place not in begins]
    yield from (f"{bare[:place]}&{bare[place:]}" for place in [*begins, *within])


def _without(text: str) -> str:
    """The text without a mark; ``&&`` is the sign itself and stays."""
    bare = _APART.sub("", text)
    return _MARK.sub(lambda found: found[1] or "&&", bare)
