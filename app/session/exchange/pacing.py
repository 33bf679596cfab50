"""Rate of steps: the limit and the measured speed."""

from __future__ import annotations

import time
from collections.abc import Callable

_MEASURED_OVER = 0.5


class Pacer:
    """Gives the time to wait for the next step; `clock` gives seconds."""

    def __init__(self, clock: Callable[[], float] = time.perf_counter) -> None:
        self._clock = clock
        self._limit: float | None = None
        self._due = 0.0
        self._counted = 0
        self._since = clock()
        self.per_second = 0.0

    def limit(self, steps_per_second: float | None) -> None:
        """Take at most so many steps a second; None for no limit."""
        self._limit = steps_per_second
        self._due = self._clock()

    def begin(self) -> None:
        """Start measuring, as when a run continues after a pause."""
        self._due = self._since = self._clock()
        self._counted = 0

    def wait(self) -> float:
        """Seconds until the next step is due, 0 when it is."""
        return 0.0 if self._limit is None else max(0.0, self._due - self._clock())

    def stepped(self) -> None:
        """Count a step."""
        now = self._clock()
        if self._limit is not None:
            # A late step is not made up for: the display should not race after a pause.
            self._due = max(self._due + 1.0 / self._limit, now)
        self._counted += 1
        if now - self._since >= _MEASURED_OVER:
            self.per_second = self._counted / (now - self._since)
            self._counted, self._since = 0, now
