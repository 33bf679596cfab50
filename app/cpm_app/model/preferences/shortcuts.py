"""Keys that the user has assigned to actions, and conflicts between them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence

from cpm_app.model.text.language import tr
from cpm_core.numerics.types import Texts, frozen

SHORTCUTS_KEY = "shortcuts"
"""Key in the file of preferences: assigned keys of all actions, as one line of JSON."""

RESERVED_KEYS = (
    "Enter", "Return", "Left", "Right", "Up", "Down", "Shift+Left", "Shift+Right", "Shift+Up", "Shift+Down", "Home",
    "End", "[", "]", *"123456789",
)  # fmt: skip
"""Keys that the image itself takes; no action can have them."""


@frozen
class ActionKeys:
    """An action with its keys: name in code, title, group in the list, default keys."""

    name: str
    title: str
    group: str
    default: Texts


CustomKeys = Mapping[str, Texts]
"""Assigned keys by the names of actions; actions that are missing have their default keys."""


def parse_shortcuts(stored: str) -> dict[str, Texts]:
    """Parse assigned keys from the file; what cannot be read is left out."""
    try:
        found = json.loads(stored)
    except (ValueError, RecursionError):
        return {}
    return {
        name: tuple(keys)
        for name, keys in (found.items() if isinstance(found, dict) else ())
        if isinstance(keys, list) and all(isinstance(key, str) for key in keys)
    }


def encode_shortcuts(custom: CustomKeys) -> str:
    """Encode assigned keys for the file."""
    return json.dumps({name: list(keys) for name, keys in custom.items()})


def find_action_keys(action: ActionKeys, custom: CustomKeys) -> Texts:
    """Return the keys of an action."""
    return custom.get(action.name, action.default)


def find_key_holder(key: str, actions: Iterable[ActionKeys], custom: CustomKeys, excluded: str) -> ActionKeys | None:
    """Find the action that has a key, apart from the one named `excluded`."""
    return next((one for one in actions if one.name != excluded and key in find_action_keys(one, custom)), None)


def assign_key(key: str, action: ActionKeys, actions: Sequence[ActionKeys], custom: CustomKeys) -> dict[str, Texts]:
    """Assign one key to an action in place of its own; another action that had it loses it."""
    changed = {**custom, action.name: (key,) if key else ()}
    other = find_key_holder(key, actions, custom, excluded=action.name) if key else None
    if other is not None:
        changed[other.name] = tuple(own for own in find_action_keys(other, custom) if own != key)
    known = {one.name: one.default for one in actions}
    return {name: keys for name, keys in changed.items() if keys != known.get(name)}


def explain_reserved_key(key: str) -> str:
    """Tell why a key cannot be assigned; empty if it can."""
    if key in RESERVED_KEYS:
        return tr("{key} is reserved for the image: choose another key.", key=key)
    return ""
