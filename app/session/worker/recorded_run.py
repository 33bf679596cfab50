"""The timeline of the run on the worker thread, with the record for plots that belongs to each branch."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from app.session.exchange.messages import RunMetrics
from app.session.timeline.run_actions import RunAction, Stepped
from app.session.timeline.timeline import Outline, Timeline
from cpm_core.image.regions import Regions
from cpm_core.numerics.types import Array
from cpm_core.segmentation.method import Method, MethodState

MEGABYTES = 256
"""Memory for the timeline where nothing else is preferred."""

MEGABYTE = 2**20

_METHODS = 3
"""Methods with different regions that are kept for taking steps anew."""

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


class RecordedRun:
    """Timeline and records of one run after the other."""

    def __init__(self) -> None:
        self.timeline: Timeline[RunAction] = Timeline(self._apply, MEGABYTES * MEGABYTE)
        self._methods: dict[Regions | None, Method[Any]] = {}
        self._records: dict[int, RunRecord] = {}

    @property
    def outline(self) -> Outline:
        """How it stands."""
        timeline = self.timeline
        branch, _ = timeline.here or (0, 0)
        taken = next((action.parameters for action in timeline.actions if isinstance(action, Stepped)), None)
        return Outline(timeline.branches, branch, timeline.used, timeline.budget, timeline.kept, taken)

    def clear(self) -> None:
        """Forget the run."""
        self.timeline.clear()
        self._methods.clear()
        self._records.clear()

    def begin(self, method: Method[Any], state: MethodState, record: RunRecord) -> None:
        """Begin with the first state of a run."""
        self._methods = {method.regions: method}
        self.timeline.begin(state)
        self._records = {self.outline.branch: record}

    def record(self, action: RunAction, state: MethodState, record: RunRecord) -> None:
        """Add a step; the recorder has it already."""
        self.timeline.record(action, state)
        self._keep(record)

    def amend(self, action: RunAction, state: MethodState, record: RunRecord) -> None:
        """Change the state where the run stands, as by particles that join, without a step."""
        self.timeline.amend(action, state)
        self._keep(record)

    def go(self, branch: int, step: int, wanted: Callable[[], bool]) -> tuple[MethodState, RunRecord] | None:
        """Go to another step: its state and the record up to it; None when that was no longer wanted."""
        state = self.timeline.go(branch, step, wanted)
        return None if state is None else (state, self._records[branch].until(state.step))

    def moment(self, branch: int, step: int, wanted: Callable[[], bool]) -> tuple[MethodState, RunRecord] | None:
        """State of another step as `go` gives it, without going there."""
        state = self.timeline.state(branch, step, wanted)
        return None if state is None else (state, self._records[branch].until(state.step))

    def drop(self, branch: int) -> tuple[MethodState, RunRecord]:
        """Forget a branch: the state where the run stands then, and the record up to it."""
        self.timeline.drop(branch)
        self._records.pop(branch)
        here = self.timeline.here
        assert here is not None
        back = self.go(*here, lambda: True)
        assert back is not None
        return back

    def _keep(self, record: RunRecord) -> None:
        """Let a branch have the record that reaches furthest."""
        here = self.timeline.here
        assert here is not None
        known = self._records.get(here[0])
        if known is None or len(record) >= len(known):
            self._records[here[0]] = record

    def _apply(self, state: MethodState, action: RunAction) -> MethodState:
        method = self._methods.pop(action.regions, None)
        if method is None:
            method = next(iter(self._methods.values())).with_regions(action.regions)
            if len(self._methods) >= _METHODS:
                self._methods.pop(next(iter(self._methods)))
        self._methods[action.regions] = method  # used last, and therefore let go last
        after: MethodState = action.apply(method, state)
        return after
