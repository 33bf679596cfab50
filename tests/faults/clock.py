"""The time that the program had: on a busy computer, others keep its threads from going on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

_LOOKS_EVERY = 0.25
"""Time after which the threads are looked at again [s]: that takes some of it."""

_THREADS = Path("/proc/self/task")


def waits() -> dict[str, float]:
    """How long each thread of this process has been ready and got no processor [s]; nothing where that is not told."""
    found = {}
    for thread in _THREADS.iterdir() if _THREADS.is_dir() else ():
        try:
            found[thread.name] = 1e-9 * int((thread / "schedstat").read_text().split()[1])
        except OSError:  # it has just ended
            continue
    return found


class Clock:
    """Time on the clock, without that in which a thread of this process waited for a processor [s].

    Whatever waits for that thread waits with it.
    """

    def __init__(
        self, time_now: Callable[[], float] = time.monotonic, waits_now: Callable[[], dict[str, float]] = waits
    ) -> None:
        self._time, self._waits = time_now, waits_now
        self._lock = threading.Lock()
        self._looked, self._waited, self._now = time_now(), waits_now(), 0.0

    def __call__(self) -> float:
        """The time since the beginning, to a fraction of a second."""
        with self._lock:
            passed = self._time() - self._looked
            if passed >= _LOOKS_EVERY:
                self._looked += passed
                before, self._waited = self._waited, self._waits()
                kept = max((waited - before.get(thread, 0.0) for thread, waited in self._waited.items()), default=0.0)
                self._now += max(passed - kept, 0.0)
            return self._now


now = Clock()
"""The clock of this process."""
