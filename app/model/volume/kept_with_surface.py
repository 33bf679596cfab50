"""What is worked out of a surface, kept for as long as there is the surface: those of former volumes take memory."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

from cpm_core.contours.surface import Surface

_Choice = TypeVar("_Choice", bound=Hashable)
_Made = TypeVar("_Made")

_MOST = 8
"""Number of choices for which something is kept beside one surface, such as the slices that cut it."""


def kept_with_surface(make: Callable[[Surface, _Choice], _Made]) -> Callable[[Surface, _Choice], _Made]:
    """Keep what a function makes of a surface and of the latest few choices.

    What it makes is never None, and does not refer to the surface, which it would keep otherwise.
    """
    kept: WeakKeyDictionary[Surface, dict[_Choice, _Made]] = WeakKeyDictionary()

    @wraps(make)
    def made(surface: Surface, choice: _Choice) -> _Made:
        beside = kept.setdefault(surface, {})
        found = beside.pop(choice, None)
        if found is None:
            found = make(surface, choice)
        for oldest in list(beside)[: max(len(beside) - _MOST + 1, 0)]:
            beside.pop(oldest, None)
        beside[choice] = found
        return found

    return made
