"""A slot for the newest of something, handed from one thread to another."""

from __future__ import annotations

import threading
from typing import Generic, TypeVar

T = TypeVar("T")


class Mailbox(Generic[T]):
    """One slot in which the newest wins; what was not taken in time is replaced, never queued."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._content: T | None = None

    def put(self, content: T) -> None:
        """Leave `content`, in place of whatever was not taken yet."""
        with self._lock:
            self._content = content

    def take(self) -> T | None:
        """Take what is there, or None; it is taken once."""
        with self._lock:
            content, self._content = self._content, None
            return content

    def __bool__(self) -> bool:
        return self._content is not None
