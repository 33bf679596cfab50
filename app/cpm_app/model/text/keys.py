"""Keys in sentences: shortcuts, as the user has set them.

A sentence names a key by its action, as in ``"Press {key:run} to run."`` or ``"Open an image ({key:open})."``, also in
its translations. `insert_keys` puts the keys in; the window fills the table by `use_action_names`, and again after each
change.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
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
