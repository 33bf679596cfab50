"""What a part of the fault tests is given, how long it goes on, and what it tells."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

_asked_to_stop = threading.Event()


def going_on(end: float) -> bool:
    """Whether a time of `time.monotonic` is still to come, and no signal has asked to stop."""
    return time.monotonic() < end and not _asked_to_stop.is_set()


def asked_to_stop() -> bool:
    """Whether a signal has asked to stop."""
    return _asked_to_stop.is_set()


@contextmanager
def stoppable() -> Iterator[None]:
    """Let Ctrl+C, or the signal that ends a process, end a part early, so that it tells what it has found.

    A second one ends the process as usual.
    """

    def stop(*_: object) -> None:
        _asked_to_stop.set()
        as_usual()

    def as_usual() -> None:
        for number, handler in before.items():
            signal.signal(number, handler)

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        as_usual()
        _asked_to_stop.clear()


@dataclass(frozen=True)
class Budget:
    """How long a part may go on, from which seed, and where it may write.

    Parameters
    ----------
    seconds : float
        Time after which no further input is begun.
    seed : int
        Fixes all random choices: the same seed gives the same inputs in the same order.
    folder : Path
        An empty folder for files of this part alone.
    collection : Path, optional
        A folder of files, sound and damaged ones, that are read and damaged beside the own samples.
    """

    seconds: float
    seed: int
    folder: Path
    collection: Path | None = None


@dataclass(frozen=True)
class Report:
    """What was tried, and what failed.

    Parameters
    ----------
    inputs : int
        Files, calls, sessions or events that were tried.
    faults : int
        Kills, full disks, failed writes and the like that were injected.
    failures : tuple of str
        One sentence for each failure, with what repeats it.
    seconds : float
        Time taken; set by whoever runs the part.
    told : tuple of str
        What has been measured beside this, one sentence each.
    """

    inputs: int
    faults: int = 0
    failures: tuple[str, ...] = field(default=())
    seconds: float = 0.0
    told: tuple[str, ...] = field(default=())


Part = Callable[[Budget], Report]
