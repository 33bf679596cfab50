"""Keys that the user has assigned to actions, and conflicts between them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence

from cpm_app.model.text.language import tr
from cpm_core.numerics.types import Texts, frozen

KEY = "shortcuts"
"""Key in the file of preferences: assigned keys of all actions, as one line of JSON."""

ON_THE_IMAGE = (
    "Enter", "Return", "Left", "Right", "Up", "Down", "Shift+Left", "Shift+Right", "Shift+Up", "Shift+Down", "Home",
    "End", "[", "]", *"123456789",
)  # fmt: skip
"""Keys that the image itself takes; no action can have them."""


@frozen
class Keyed:
    """An action with its keys: name in code, title, group in the list, default keys."""

    name: str
    title: str
    group: str
    default: Texts


Chosen = Mapping[str, Texts]
"""Assigned keys by the names of actions; actions that are missing have their default keys."""


def read(stored: str) -> dict[str, Texts]:
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


def written(chosen: Chosen) -> str:
    """Encode assigned keys for the file."""
    return json.dumps({name: list(keys) for name, keys in chosen.items()})


def keys_of(action: Keyed, chosen: Chosen) -> Texts:
    """Return the keys of an action."""
    return chosen.get(action.name, action.default)


def holder(key: str, actions: Iterable[Keyed], chosen: Chosen, besides: str = "") -> Keyed | None:
    """Find the action that has a key, apart from the one named `excluded`."""
    return next((one for one in actions if one.name != besides and key in keys_of(one, chosen)), None)


def with_key(key: str, action: Keyed, actions: Sequence[Keyed], chosen: Chosen) -> dict[str, Texts]:
    """Assign one key to an action in place of its own; another action that had it loses it."""
    changed = {**chosen, action.name: (key,) if key else ()}
    other = holder(key, actions, chosen, besides=action.name) if key else None
    if other is not None:
        changed[other.name] = tuple(own for own in keys_of(other, chosen) if own != key)
    known = {one.name: one.default for one in actions}
    return {name: keys for name, keys in changed.items() if keys != known.get(name)}


def refusal(key: str) -> str:
    """Tell why a key cannot be assigned; empty if it can."""
    if key in ON_THE_IMAGE:
        return tr("{key} is reserved for the image: choose another key.", key=key)
    return ""
