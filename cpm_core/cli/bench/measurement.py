"""What is measured, and how a time is taken."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Measurement:
    """One row of the table.

    Attributes
    ----------
    part : str
        Part of the program that it belongs to.
    what : str
        What was done.
    value : float
        How long it took, in `unit`.
    unit : str
        Unit of both times: "s" or "ms".
    peer : str, optional
        What else was done in the same run: another method for the same task, or what cannot be gone without.
    peer_value : float, optional
        How long that took.
    error : float, optional
        Relative error of what came out.
    growth : float, optional
        Exponent with which the time grows, from the row before to this one, with what there is more of.
    note : str
        What else is to be known.
    """

    part: str
    what: str
    value: float
    unit: str = "ms"
    peer: str | None = None
    peer_value: float | None = None
    error: float | None = None
    growth: float | None = None
    note: str = ""

    @property
    def ratio(self) -> float | None:
        """Our time divided by the peer's."""
        return self.value / self.peer_value if self.peer_value else None


@dataclass(frozen=True)
class Patience:
    """How long to look.

    Attributes
    ----------
    seconds : float
        Time to spend on one piece of work, once it has been done twice [s].
    repeats : int
        How often to do it at most.
    quick : bool
        Whether to leave out what is large.
    """

    seconds: float = 1.0
    repeats: int = 15
    quick: bool = False


_LONG = 3.0
"""How many times the time to spend something must take to be done only once."""

TOO_LONG = 20.0
"""What is expected to take longer than this is left out [s]."""

UNHURRIED, QUICK = Patience(), Patience(seconds=0.05, repeats=3, quick=True)


def seconds_of(patience: Patience, *works: Callable[[], object]) -> list[float]:
    """Median times that several pieces of work take [s].

    They are done in turn, so that whatever else the machine does meanwhile slows down one as much as the other. The
    first round fills caches and does not count, unless it has taken so long that this makes no difference.
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
    """Median times that several pieces of work take [ms]; see `seconds_of`."""
    return [1e3 * seconds for seconds in seconds_of(patience, *works)]


def _round(works: Sequence[Callable[[], object]]) -> list[float]:
    """How long each piece of work takes, done once [s]."""
    times = []
    for work in works:
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return times
