"""A cache that keeps nothing alive of what its values were computed from."""

from __future__ import annotations

import weakref
from collections.abc import Callable, Hashable
from typing import Generic, TypeVar

Value = TypeVar("Value")


class WeakCache(Generic[Value]):
    """The values that were asked for last, each only as long as the object lives that it was computed from.

    Parameters
    ----------
    size : int
        Largest number of values.
    """

    def __init__(self, size: int) -> None:
        self._size = size
        self._kept: dict[Hashable, tuple[weakref.ref[object], Value]] = {}

    def get(self, compute: Callable[..., Value], owner: object, *rest: Hashable) -> Value:
        """Return ``compute(owner, *rest)``, perhaps computed before."""
        key = id(owner), *rest
        known = self._kept.pop(key, None)
        if known is None or known[0]() is not owner:
            known = weakref.ref(owner, lambda _: self._kept.pop(key, None)), compute(owner, *rest)
        self._kept[key] = known
        for oldest in [*self._kept][: -self._size]:
            self._kept.pop(oldest, None)
        return known[1]
