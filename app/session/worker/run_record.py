"""The record of a run for plots."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields

import numpy as np

from app.session.exchange.messages import RunMetrics
from cpm_core.numerics.types import Array

_FIRST_CAPACITY = 1024
_NAMES = [field.name for field in fields(RunMetrics)]


class RunRecord:
    """Grows by one entry a step; what it has given out is never written again."""

    def __init__(self) -> None:
        self._rows: Array = np.empty((len(_NAMES), _FIRST_CAPACITY))
        self._length = 0

    def record(self, step: int, measures: Mapping[str, float]) -> None:
        """Add one step; where the potential energy is not measured, the last one stands for it."""
        if self._length == self._rows.shape[1]:
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)], axis=1)
        row = {"step": float(step), **measures}
        if self._length:
            row.setdefault("potential", float(self._rows[_NAMES.index("potential"), self._length - 1]))
        self._rows[:, self._length] = [row.get(name, math.nan) for name in _NAMES]
        self._length += 1

    def __len__(self) -> int:
        return self._length

    def until(self, length: int) -> RunRecord:
        """Another record that begins with the first so many entries of this one."""
        other = RunRecord()
        other._length = min(length, self._length)
        room = max(2 * other._length, _FIRST_CAPACITY)
        other._rows = np.empty((len(self._rows), room))
        other._rows[:, : other._length] = self._rows[:, : other._length]
        return other

    def metrics(self) -> RunMetrics:
        """The record so far, without copying it."""
        return RunMetrics(*self._rows[:, : self._length])
