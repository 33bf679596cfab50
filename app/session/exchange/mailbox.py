"""The newest wins: a slot between two threads."""

from __future__ import annotations

from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class Mailbox(Generic[T]):
    """One slot in which the newest wins; content that was not taken in time is replaced, never queued.

    No thread waits for another: a deque of length one replaces and returns its content in single atomic operations.
    With a lock, the window would have to wait for a worker that was interrupted while holding it.
    """

    def __init__(self) -> None:
        self._content: deque[T] = deque(maxlen=1)

    def put(self, content: T) -> None:
        """Leave `content` in place of any that was not taken yet."""
        self._content.append(content)

    def take(self) -> T | None:
        """Take the content once, or None."""
        try:
            return self._content.pop()
        except IndexError:
            return None

    @property
    def newest(self) -> T | None:
        """The content without taking it, or None."""
        try:
            return self._content[-1]
        except IndexError:
            return None

    def __bool__(self) -> bool:
        return bool(self._content)
