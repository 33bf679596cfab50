"""Disks that fail: each operation on files in turn, files that may not grow, and the window on such a disk."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from pathlib import Path

from ..kills.command_line import draw_images
from ..kills.nursery import outcome
from ..report import Budget, Report, asked_to_stop, going_on
from .core import WORKS, Disk
from .window import trials

_OF_THE_WINDOW = 0.3
"""Part of the time that is for the window."""

_LARGEST = 20_000
"""Length that no file of these tests reaches [bytes]."""


def failed(budget: Budget) -> Report:
    """Let operations on files fail, in the window and outside of it."""
    drawn = random.Random(budget.seed)
    window = _new(budget.folder / "window")
    draw_images(window)
    seconds = _OF_THE_WINDOW * budget.seconds
    told = outcome(window, trials, window, seconds, 1, budget.seed, busy=seconds)
    count, failures = told.value if not told.killed else (0, [] if asked_to_stop() else ["the window has died"])
    end = time.monotonic() + (1.0 - _OF_THE_WINDOW) * budget.seconds
    disks = {kind: Disk(_new(budget.folder / kind), kind) for kind in WORKS}
    waiting = {kind: drawn.sample(disk.trials(), len(disk.trials())) for kind, disk in disks.items()}
    while going_on(end):
        for kind, disk in disks.items():
            size = drawn.randint(0, _LARGEST)
            planned: list[Callable[[], object]] = [lambda disk=disk, size=size: disk.limited(size)]
            if waiting[kind]:
                number, error, lasting = waiting[kind].pop()
                planned.append(lambda disk=disk, of=(number, error, lasting): disk.trial(*of))
            for trial in planned:
                count += 1
                try:
                    trial()
                except AssertionError as failure:
                    failures.append(str(failure))
    return Report(count, count, tuple(failures))


def _new(folder: Path) -> Path:
    folder.mkdir()
    return folder
