"""Work that fails in the middle: processes that die, memory that is not enough."""

from __future__ import annotations

import random
import time
from collections.abc import Callable

from ..report import Budget, Report, going_on
from .command_line import Memory, Workers

_MOST = 150.0
"""Memory with which each run of these tests comes to its end [MiB]."""


def broken(budget: Budget) -> Report:
    """Let runs and batches fail."""
    drawn = random.Random(budget.seed)
    folders = {name: budget.folder / name for name in ("memory", "workers")}
    for folder in folders.values():
        folder.mkdir()
    count, failures, end = 0, list[str](), time.monotonic() + budget.seconds
    memory, workers = Memory(folders["memory"]), Workers(folders["workers"])
    while going_on(end):
        size, kills, seed = drawn.uniform(0.0, _MOST), drawn.randint(1, 3), drawn.randrange(10**6)
        planned: tuple[Callable[[], object], ...] = (
            lambda size=size: memory.trial(size),
            lambda kills=kills, seed=seed: workers.trial(kills, seed),
        )
        for trial in planned:
            count += 1
            try:
                trial()
            except AssertionError as failure:
                failures.append(str(failure))
    return Report(count, count, tuple(failures))
