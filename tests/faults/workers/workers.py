"""Work that fails in the middle: errors in threads, processes that die, memory that is not enough."""

from __future__ import annotations

import random
import time
from collections.abc import Callable

from ..kills.command_line import draw_images
from ..kills.nursery import outcome
from ..report import Budget, Report, asked_to_stop, going_on
from .command_line import Memory, Workers
from .window import trials

_OF_THE_WINDOW = 0.5
"""Part of the time that is for the window."""

_MOST = 150.0
"""Memory with which each run of these tests comes to its end [MiB]."""


def broken(budget: Budget) -> Report:
    """Let work fail, in the window and outside of it."""
    drawn = random.Random(budget.seed)
    folders = {name: budget.folder / name for name in ("window", "memory", "workers")}
    for folder in folders.values():
        folder.mkdir()
    draw_images(folders["window"])
    seconds = _OF_THE_WINDOW * budget.seconds
    told = outcome(folders["window"], trials, folders["window"], seconds, 3, budget.seed, busy=seconds)
    count, failures = told.value if not told.killed else (0, [] if asked_to_stop() else ["the window has died"])
    end = time.monotonic() + (1.0 - _OF_THE_WINDOW) * budget.seconds
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
