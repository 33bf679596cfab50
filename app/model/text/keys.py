"""Keys of actions in sentences, as they are at the moment: the user may have changed them.

A sentence names a key by its action, as in ``"Press {key:run} to run."`` or ``"Open an image ({key:open})."``, also in
its translations. `with_keys` puts the keys in; the window fills the table by `use_names`, and again after each change.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
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
    """A sentence with the keys of actions, and with the values of what else stands in braces.

    An action without a key is called by its title; in parentheses, behind its title, it is left out.
    """

    def behind(found: re.Match[str]) -> str:
        return found[0] if found[1] in _names and _names[found[1]].key else ""

    return _IN_PARENTHESES.sub(behind, said).format(key=_Keys(), **values)
