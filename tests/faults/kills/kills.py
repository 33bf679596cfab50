"""Kills at random moments, and before each operation on files in turn, for as long as is asked."""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from pathlib import Path

from ..report import Budget, Report, going_on
from .command_line import Batches, Kill, Runs
from .nursery import killed_after, killed_before
from .windows import Windows

_KINDS = {"run": Runs, "batch": Batches, "window": Windows}
_LONGEST = {"run": 0.4, "batch": 0.8, "window": 2.5}
"""Time after which nothing is left to be killed [s]."""


def killed(budget: Budget) -> Report:
    """Kill runs, batches and windows in turn; the first failure of a kind names what repeats it."""
    end, drawn = time.monotonic() + budget.seconds, random.Random(budget.seed)
    victims = {name: kind(_new(budget.folder / name)) for name, kind in _KINDS.items()}
    failures: list[str] = []
    count = 0
    while True:
        for name, victim in victims.items():
            kill, moment = _drawn(name, victim.operations, drawn)
            count += _tried(failures, f"{name}, {moment}", lambda victim=victim, kill=kill: victim.trial(kill))
            if not going_on(end):
                return Report(count, count, tuple(failures))


def _drawn(name: str, operations: int, drawn: random.Random) -> tuple[Kill, str]:
    """A moment at which a process is killed, and how to say it."""
    if drawn.random() < 0.5:
        operation = drawn.randint(1, operations)
        return lambda *arguments: killed_before(operation, *arguments), f"before operation {operation}"
    seconds = drawn.uniform(0.0, _LONGEST[name])
    return lambda *arguments: killed_after(seconds, *arguments), f"after {seconds:.3f} s"


def _tried(failures: list[str], what: str, trial: Callable[[], None]) -> int:
    try:
        trial()
    except Exception as error:  # whatever it is, the others are tried
        failures.append(f"{what}: {type(error).__name__}: {error}")
    return 1


def _new(folder: Path) -> Path:
    folder.mkdir()
    return folder
