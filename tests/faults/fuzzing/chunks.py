"""Chunks: a property of Hypothesis as a trial, so that it goes on for as long as it is told."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.strategies import SearchStrategy

from .limits import in_time

_EXAMPLES = 50
_PHASES = (Phase.generate, Phase.target)  # without making a failure simpler, which may take longer than the time left


def chunk(
    strategy: SearchStrategy[Any], attempt: Callable[[Any], None], seconds: float
) -> Callable[[Random, Path], int]:
    """A trial of some examples of a strategy, each within so much processor time."""

    def trial(random: Random, _folder: Path, examples: int = _EXAMPLES) -> int:
        count = 0

        @seed(random.getrandbits(32))
        @settings(
            max_examples=examples,
            deadline=None,
            database=None,
            phases=_PHASES,
            suppress_health_check=list(HealthCheck),
            print_blob=False,
        )
        @given(strategy)
        def every(example: Any) -> None:
            nonlocal count
            count += 1
            try:
                with in_time(seconds):
                    attempt(example)
            except BaseException as error:
                error.args = (f"{error} with {' '.join(repr(example).split())[:400]}",)
                raise

        every()
        return count

    return trial
