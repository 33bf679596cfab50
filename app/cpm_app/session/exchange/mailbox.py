"""Communication between two threads: a slot in which the newest content wins, and the rate of steps."""

from __future__ import annotations

import time
from collections import deque
from typing import Generic, TypeVar

Content = TypeVar("Content")


class Mailbox(Generic[Content]):
    """One slot in which the newest wins; content that is not taken in time is replaced, never queued.

    No thread waits for another: a deque of length one replaces and returns its content in single atomic operations.
    With a lock, the window would have to wait for a worker that was interrupted while holding it.
    """

    def __init__(self) -> None:
        self._content: deque[Content] = deque(maxlen=1)

    def put(self, content: Content) -> None:
        """Put `content` into the slot, in place of any that has not been taken yet."""
        self._content.append(content)

    def take(self) -> Content | None:
        """Take the content once, or None."""
        try:
            return self._content.pop()
        except IndexError:
            return None

    @property
    def newest(self) -> Content | None:
        """The content without taking it, or None."""
        try:
            return self._content[-1]
        except IndexError:
            return None

    def __bool__(self) -> bool:
        return bool(self._content)


_RATE_WINDOW = 0.5
"""Time over which the rate of steps is measured [s]."""


class Pacer:
    """Limits the rate of steps, and measures it."""

    def __init__(self) -> None:
        self._limit: float | None = None
        self._due = 0.0
        self._counted = 0
        self._since = time.perf_counter()
        self.per_second = 0.0

    def set_limit(self, steps_per_second: float | None) -> None:
        """Set the largest number of steps per second; None for no limit."""
        self._limit = steps_per_second
        self._due = time.perf_counter()

    def start_measuring(self) -> None:
        """Start measuring the rate, for example when a run continues after a pause."""
        self._due = self._since = time.perf_counter()
        self._counted = 0

    def seconds_until_due(self) -> float:
        """Return the time until the next step is due, 0 if it is [s]."""
        return 0.0 if self._limit is None else max(0.0, self._due - time.perf_counter())

    def count_step(self) -> None:
        """Count a step."""
        now = time.perf_counter()
        if self._limit is not None:
            # Make up for one late step but no more: the display should not race after a pause.
            self._due = max(self._due + 1.0 / self._limit, now - 1.0 / self._limit)
        self._counted += 1
        if now - self._since >= _RATE_WINDOW:
            self.per_second = self._counted / (now - self._since)
            self._counted, self._since = 0, now
