"""Chunks: a property of Hypothesis as a trial, so that it goes on for as long as it is told."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis.errors import HypothesisWarning
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

        warnings.simplefilter("ignore", HypothesisWarning)

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
                error.args = (f"{str(error)[:200]} with {told(example)}",)
                raise

        every()
        return count

    return trial


def told(example: Any) -> str:
    """An example in a few words, of arrays only the beginning."""
    if isinstance(example, dict):
        return ", ".join(f"{key}={told(value)}" for key, value in example.items())
    if isinstance(example, tuple) and len(example) < 6:
        return " ".join(map(told, example))
    if isinstance(example, np.ndarray):
        return f"{example.dtype} {example.shape} {' '.join(repr(example.ravel()[:8].tolist()).split())[:90]}"
    return " ".join(repr(example).split())[:90]
