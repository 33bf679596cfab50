"""What is measured, and how a time is taken."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
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
        Time to spend on one thing, once it has been done twice [s].
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


def seconds_of(work: Callable[[], object], patience: Patience) -> float:
    """Median time that some work takes [s].

    The first time that it is done fills caches and does not count, unless it has taken so long that this makes no
    difference.
    """
    began = time.perf_counter()
    work()
    times = [time.perf_counter() - began]
    if times[0] > _LONG * patience.seconds:
        return times[0]
    while len(times) == 1 or (len(times) <= patience.repeats and time.perf_counter() - began < patience.seconds):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return statistics.median(times[1:])


def milliseconds_of(work: Callable[[], object], patience: Patience) -> float:
    """Median time that some work takes [ms]; see `seconds_of`."""
    return 1e3 * seconds_of(work, patience)
