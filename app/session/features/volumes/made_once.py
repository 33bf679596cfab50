"""Parts of what is shown, each made again only when what it depends on is another object."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

T = TypeVar("T")


class Same:
    """Stands for a value that is compared by its identity."""

    def __init__(self, value: object) -> None:
        self._value = value

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self._value is other._value

    def __hash__(self) -> int:
        return id(self._value)


class MadeOnce:
    """Keeps the newest part of each name, with what it was made of."""

    def __init__(self) -> None:
        self._made: dict[str, tuple[tuple[Any, ...], Any]] = {}

    def of(self, name: str, given: tuple[Any, ...], make: Callable[[], T]) -> T:
        """What has been made of the same things before, or is made now."""
        known = self._made.get(name)
        if known is None or not is_same(known[0], given):
            known = self._made[name] = (given, make())
        made: T = known[1]
        return made

    def forget(self) -> None:
        """Keep nothing."""
        self._made.clear()


def is_same(known: tuple[Any, ...], given: tuple[Any, ...]) -> bool:
    """Whether what something is made of is what it was made of: the same objects, or equal values."""
    return len(known) == len(given) and all(
        one is other or one == other for one, other in zip(known, given, strict=True)
    )
