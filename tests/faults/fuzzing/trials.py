"""Numbered trials: each makes its inputs from its number alone, in a process that may die without an end of all."""

from __future__ import annotations

import faulthandler
import multiprocessing
import re
import signal
import time
import warnings
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path
from random import Random
from typing import Any

from ..report import Budget, Report, asked_to_stop, going_on
from .limits import failure_of, limit_memory

Trial = Callable[[Random, Path], int]
"""Makes inputs from the random numbers, tries them, and gives their number; raises when one fails."""

_STUCK = 120.0
"""Time on the clock after which a trial is taken for one that never ends [s]."""

_LOOKS_EVERY = 0.5
"""Time after which is looked whether this process is asked to stop [s]."""

_MEMORY = 12 * 2**30
_KIND = re.compile(r"^(\w*).*\[(.*)\]$", re.DOTALL)
"""The error and its place, by which failures are of one kind."""


def random_of(seed: int, number: int) -> Random:
    """Random numbers of one trial."""
    return Random(f"{seed}/{number}")


def at_once(trial: Trial, count: int, folder: Path, seed: int = 0) -> int:
    """Run the first trials in this process, and give the number of inputs."""
    return sum(trial(random_of(seed, number), folder) for number in range(count))


def at_length(trial: Trial, budget: Budget, prepare: Callable[[], object] | None = None) -> Report:
    """Run trials in other processes until the time is up; of failures of one kind the first is told."""
    deadline, number, inputs = time.monotonic() + budget.seconds, 0, 0
    failures: dict[str, str] = {}
    context = multiprocessing.get_context("spawn")
    while going_on(deadline):
        ours, theirs = context.Pipe()
        arguments = (theirs, trial, prepare, budget, number, deadline)
        child = context.Process(target=_work, args=arguments)
        child.start()
        theirs.close()
        for number, count, failure in _told(ours):
            inputs += count
            if failure:
                failures.setdefault(_KIND.sub(r"\1 \2", failure), f"trial {number} of seed {budget.seed}: {failure}")
        if asked_to_stop():
            child.terminate()
        child.join()
        if child.exitcode and not asked_to_stop():
            number += 1
            failures.setdefault(
                f"end {child.exitcode}",
                f"trial {number} of seed {budget.seed}: the process ended with status {child.exitcode}",
            )
        number += 1
    return Report(inputs, failures=tuple(failures.values()))


def _told(pipe: Connection) -> Any:
    """What a process tells until it ends, or is to end."""
    with suppress(EOFError):
        while not asked_to_stop():
            if pipe.poll(_LOOKS_EVERY):
                yield pipe.recv()


def _work(
    pipe: Connection, trial: Trial, prepare: Callable[[], object] | None, budget: Budget, first: int, deadline: float
) -> None:
    """Run trials and tell each: its number, its inputs, and what failed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl+C is answered by the process that hears of the trials
    limit_memory(_MEMORY)
    warnings.simplefilter("error")  # a warning that nobody expects is trouble that nobody is told of
    if prepare is not None:
        prepare()
    number = first
    while number == first or time.monotonic() < deadline:
        faulthandler.dump_traceback_later(_STUCK, exit=True)
        try:
            count, failure = trial(random_of(budget.seed, number), budget.folder), ""
        except BaseException as error:
            count, failure = 1, failure_of(error)
        pipe.send((number, count, failure))
        number += 1
    faulthandler.cancel_dump_traceback_later()
