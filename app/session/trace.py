"""The record of a run for plots."""

from __future__ import annotations

import numpy as np

from app.session.messages import Array, Trace

_FIRST_CAPACITY = 1024


class Recorder:
    """Grows by one entry a step; what it has given out is never written again."""

    def __init__(self) -> None:
        self._rows: Array = np.empty((3, _FIRST_CAPACITY))
        self._length = 0

    def record(self, step: int, epsilon: float, count: int) -> None:
        """Add one step."""
        if self._length == self._rows.shape[1]:
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)], axis=1)
        self._rows[:, self._length] = step, epsilon, count
        self._length += 1

    def trace(self) -> Trace:
        """The record so far, without copying it."""
        step, epsilon, count = self._rows[:, : self._length]
        return Trace(step, epsilon, count)
