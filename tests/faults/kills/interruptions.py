"""Interruptions: an error that a signal raises at a random moment of a call ends the call, and nothing else.

That is what Ctrl+C does in a notebook: the process lives, and the next call gives what it gave before.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

import cpm_core
from cpm_core import PRESETS, Parameters, circle, segment, sphere
from cpm_core.numerics.types import Array

from ..fuzzing.trials import at_length
from ..report import Budget, Report

_ROW, _COL = np.indices((40, 44))
_DISC = np.where(np.hypot(_ROW - 20, _COL - 22) < 12, 200.0, 20.0)
_BALL = np.where(np.linalg.norm(np.indices((16, 16, 16)) - 7.5, axis=0) < 5.0, 100.0, 0.0)
_WITHIN = 60.0
"""Time after which a call that follows an interruption is taken for one that never ends [s]."""

_LEAST = 1e-5


class Interrupted(BaseException):
    """What the signal raises."""


class NeverEnds(BaseException):
    """A call goes on after the time in which it must be done."""


def _surface() -> Array:
    found = segment(_BALL, sphere((7.5, 7.5, 7.5), 2.5, 60), PRESETS["volume"]).surface
    assert found is not None
    return found.vertices


_CALLS: Mapping[str, Callable[[], Array]] = {
    "run": lambda: segment(_DISC, circle((20, 22), 6.0), Parameters(scales=2)).particles,
    "volume": _surface,
    "object": lambda: cpm_core.partition(_DISC).select(np.array([[20.0, 22.0]])).mask,
    "skeleton": lambda: np.concatenate([contour.points for contour in cpm_core.skeleton(_DISC).contours]),
}


class Calls:
    """What is called, what it gives, and how long it takes."""

    def __init__(self) -> None:
        for call in _CALLS.values():
            call()
        self._found, self._seconds = dict[str, Array](), dict[str, float]()
        for name, call in _CALLS.items():
            began = time.perf_counter()
            self._found[name] = call()
            self._seconds[name] = time.perf_counter() - began

    def trial(self, random: Random) -> None:
        """Interrupt a call at a random moment; fails unless all calls then give what they gave."""
        name = random.choice(sorted(_CALLS))
        _raising_after(max(_LEAST, random.uniform(0.0, self._seconds[name])), _CALLS[name])
        other = random.choice(sorted(_CALLS))
        again = _within(_CALLS[other])
        assert np.array_equal(again, self._found[other]), f"{other} gives something else after {name} was interrupted"


def _raising_after(seconds: float, call: Callable[[], Any]) -> None:
    """Call, and let a signal raise after so long; libraries may make other errors of it."""

    def interrupt(*_: object) -> None:
        raise Interrupted

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        signal.setitimer(signal.ITIMER_REAL, seconds)
        call()
        signal.setitimer(signal.ITIMER_REAL, 0.0)
    except (Interrupted, Exception):
        pass
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _within(call: Callable[[], Array]) -> Array:
    """What a call gives; fails when it never ends."""

    def stop(*_: object) -> None:
        raise NeverEnds(f"a call goes on for {_WITHIN:g} s after an interruption")

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, _WITHIN)
    try:
        return call()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


_known: list[Calls] = []


def prepare() -> None:
    """Compile all loops, and learn what the calls give."""
    _known.append(Calls())


def interrupted(budget: Budget) -> Report:
    """Interrupt calls until the time is up."""
    report = at_length(trial, budget, prepare)
    return replace(report, faults=report.inputs)


def trial(random: Random, _folder: Path, count: int = 20) -> int:
    """Interrupt some calls."""
    for _ in range(count):
        _known[-1].trial(random)
    return count
