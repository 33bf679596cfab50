"""Keys of actions that the user has chosen, and conflicts between them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence

from cpm_app.model.text.language import tr
from cpm_core.numerics.types import Texts, frozen

KEY = "shortcuts"
"""Key of the file of preferences: the chosen keys of all actions, as one line of JSON."""

ON_THE_IMAGE = (
    "Enter", "Return", "Left", "Right", "Up", "Down", "Shift+Left", "Shift+Right", "Shift+Up", "Shift+Down", "Home",
    "End", "[", "]", *"123456789",
)  # fmt: skip
"""Keys that the image itself takes; no action can have them."""


@frozen
class Keyed:
    """An action with its keys: name in code, title, group in the list, keys by default."""

    name: str
    title: str
    group: str
    default: Texts


Chosen = Mapping[str, Texts]
"""Keys by the names of actions; one that is not there has its default ones."""


def read(stored: str) -> dict[str, Texts]:
    """Chosen keys from the file; what cannot be read is left out."""
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
    """Chosen keys as they are stored."""
    return json.dumps({name: list(keys) for name, keys in chosen.items()})


def keys_of(action: Keyed, chosen: Chosen) -> Texts:
    """The keys of an action."""
    return chosen.get(action.name, action.default)


def holder(key: str, actions: Iterable[Keyed], chosen: Chosen, besides: str = "") -> Keyed | None:
    """The action that has a key, apart from the one named `besides`."""
    return next((one for one in actions if one.name != besides and key in keys_of(one, chosen)), None)


def with_key(key: str, action: Keyed, actions: Sequence[Keyed], chosen: Chosen) -> dict[str, Texts]:
    """Chosen keys after an action has got one key in place of its own; an action that had it loses it."""
    changed = {**chosen, action.name: (key,) if key else ()}
    other = holder(key, actions, chosen, besides=action.name) if key else None
    if other is not None:
        changed[other.name] = tuple(own for own in keys_of(other, chosen) if own != key)
    known = {one.name: one.default for one in actions}
    return {name: keys for name, keys in changed.items() if keys != known.get(name)}


def refusal(key: str) -> str:
    """Why a key cannot be chosen, empty if it can."""
    if key in ON_THE_IMAGE:
        return tr("{key} is reserved for the image: choose another key.", key=key)
    return ""
