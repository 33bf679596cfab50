"""How often something happens: the limit and the measured speed."""

from __future__ import annotations

import time
from collections.abc import Callable

_MEASURED_OVER = 0.5


class Pacer:
    """Says how long to wait for the next step.

    Parameters
    ----------
    clock : callable
        Seconds that only go forward.
    """

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
        """Start measuring, as when a run goes on after a pause."""
        self._due = self._since = self._clock()
        self._counted = 0

    def wait(self) -> float:
        """Seconds until the next step is due, 0 when it is."""
        return 0.0 if self._limit is None else max(0.0, self._due - self._clock())

    def stepped(self) -> None:
        """Count a step."""
        now = self._clock()
        if self._limit is not None:
            # A step that came late is not made up for: the picture should not race after a pause.
            self._due = max(self._due + 1.0 / self._limit, now)
        self._counted += 1
        if now - self._since >= _MEASURED_OVER:
            self.per_second = self._counted / (now - self._since)
            self._counted, self._since = 0, now
