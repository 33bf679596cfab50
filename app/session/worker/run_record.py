"""The record of a run for plots."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from app.session.exchange.messages import RunMetrics
from cpm_core.dynamics.energies import kinetic_energy
from cpm_core.numerics.types import Array
from cpm_core.particles.state import State

_FIRST_CAPACITY = 1024
_POTENTIAL = [field.name for field in fields(RunMetrics)].index("potential")


class RunRecord:
    """Grows by one entry a step; what it has given out is never written again."""

    def __init__(self) -> None:
        self._rows: Array = np.empty((len(fields(RunMetrics)), _FIRST_CAPACITY))
        self._length = 0

    def record(self, state: State, potential: float | None = None) -> None:
        """Add one step; where its potential energy is not given, the one before stands for it."""
        if self._length == self._rows.shape[1]:
            self._rows = np.concatenate([self._rows, np.empty_like(self._rows)], axis=1)
        if potential is None:
            potential = float(self._rows[_POTENTIAL, self._length - 1]) if self._length else float("nan")
        self._rows[:, self._length] = (
            state.step,
            state.epsilon,
            state.count,
            state.born,
            state.deleted,
            kinetic_energy(state),
            potential,
            state.scale,
            state.next_identity,
        )
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
