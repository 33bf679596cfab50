"""The timeline of the run on the worker thread, with the record for plots that belongs to each branch."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from app.session.timeline.run_actions import RunAction, Stepped
from app.session.timeline.timeline import Outline, Timeline
from app.session.worker.run_record import RunRecord
from cpm_core.image.regions import Regions
from cpm_core.segmentation.method import Method, MethodState

MEGABYTES = 256
"""Memory for the timeline where nothing else is preferred."""

MEGABYTE = 2**20

_METHODS = 3
"""Methods with different regions that are kept for taking steps anew."""


class RecordedRun:
    """Timeline and records of one run after the other."""

    def __init__(self) -> None:
        self._timeline: Timeline[RunAction] = Timeline(self._apply, MEGABYTES * MEGABYTE)
        self._methods: dict[Regions | None, Method[Any]] = {}
        self._records: dict[int, RunRecord] = {}

    @property
    def outline(self) -> Outline:
        """How it stands."""
        timeline = self._timeline
        branch, _ = timeline.here or (0, 0)
        taken = next((action.parameters for action in timeline.actions if isinstance(action, Stepped)), None)
        return Outline(timeline.branches, branch, timeline.used, timeline.budget, timeline.kept, taken)

    def set_budget(self, budget: int) -> None:
        """Let states take so many bytes at most."""
        self._timeline.budget = budget

    def clear(self) -> None:
        """Forget the run."""
        self._timeline.clear()
        self._methods.clear()
        self._records.clear()

    def begin(self, method: Method[Any], state: MethodState, record: RunRecord) -> None:
        """Begin with the first state of a run."""
        self._methods = {method.regions: method}
        self._timeline.begin(state)
        self._records = {self.outline.branch: record}

    def record(self, action: RunAction, state: MethodState, record: RunRecord) -> None:
        """Add a step; the recorder has it already."""
        self._timeline.record(action, state)
        self._keep(record)

    def amend(self, action: RunAction, state: MethodState, record: RunRecord) -> None:
        """Change the state where the run stands, as by particles that join, without a step."""
        self._timeline.amend(action, state)
        self._keep(record)

    def go(self, branch: int, step: int, wanted: Callable[[], bool]) -> tuple[MethodState, RunRecord] | None:
        """Go to another step: its state and the record up to it; None when that was no longer wanted."""
        state = self._timeline.go(branch, step, wanted)
        return None if state is None else (state, self._records[branch].until(state.step))

    def state(self, branch: int, step: int, wanted: Callable[[], bool]) -> MethodState | None:
        """State of another step, or of the last one of a shorter branch; None when it was no longer wanted."""
        return self._timeline.state(branch, step, wanted)

    def moment(self, branch: int, step: int, wanted: Callable[[], bool]) -> tuple[MethodState, RunRecord] | None:
        """State of another step as `go` gives it, without going there."""
        state = self._timeline.state(branch, step, wanted)
        return None if state is None else (state, self._records[branch].until(state.step))

    def rename(self, branch: int, name: str) -> None:
        """Give a branch another name."""
        self._timeline.rename(branch, name)

    def drop(self, branch: int) -> tuple[MethodState, RunRecord]:
        """Forget a branch: the state where the run stands then, and the record up to it."""
        self._timeline.drop(branch)
        self._records.pop(branch)
        here = self._timeline.here
        assert here is not None
        back = self.go(*here, lambda: True)
        assert back is not None
        return back

    def _keep(self, record: RunRecord) -> None:
        """Let a branch have the record that reaches furthest."""
        here = self._timeline.here
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
