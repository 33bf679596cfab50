"""Measurements: a row of the table, and how times are taken."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Measurement:
    """One row of the table: our time, and that of a peer, another method for the same task or a lower bound."""

    part: str  # of the program
    what: str
    value: float  # our time
    unit: str = "ms"  # of both times, "s" or "ms"
    peer: str | None = None
    peer_value: float | None = None  # time of the peer, measured in the same run
    note: str = ""

    @property
    def ratio(self) -> float | None:
        """Our time divided by the peer's."""
        return self.value / self.peer_value if self.peer_value else None


@dataclass(frozen=True)
class Patience:
    """Limits of a measurement."""

    seconds: float = 1.0  # time for one task, after it has been done twice [s]
    repeats: int = 15  # at most
    quick: bool = False  # whether large inputs are left out


_LONG = 3.0
"""A task that takes this many times `Patience.seconds` is done only once."""

UNHURRIED, QUICK = Patience(), Patience(seconds=0.05, repeats=3, quick=True)


def seconds_of(patience: Patience, *works: Callable[[], object]) -> list[float]:
    """Median times of several tasks [s].

    They are done in turn, so that other load on the machine slows down all of them equally. The first round fills
    caches and does not count, unless it takes so long that caches make no difference.
    """
    began = time.perf_counter()
    rounds = [_round(works)]
    if sum(rounds[0]) > _LONG * patience.seconds * len(works):
        return rounds[0]
    end = began + patience.seconds * len(works)
    while len(rounds) == 1 or (len(rounds) <= patience.repeats and time.perf_counter() < end):
        rounds.append(_round(works))
    return [statistics.median(times) for times in zip(*rounds[1:], strict=True)]


def milliseconds_of(patience: Patience, *works: Callable[[], object]) -> list[float]:
    """Median times of several tasks [ms]; see `seconds_of`."""
    return [1e3 * seconds for seconds in seconds_of(patience, *works)]


def _round(works: Sequence[Callable[[], object]]) -> list[float]:
    """Time of each task, done once [s]."""
    times = []
    for work in works:
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return times
