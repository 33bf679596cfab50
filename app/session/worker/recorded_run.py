"""The timeline of the run on the worker thread, with the record for plots that belongs to each branch."""

from __future__ import annotations

from collections.abc import Callable

from app.session.timeline.run_actions import RunAction, Stepped
from app.session.timeline.timeline import Outline, Timeline
from app.session.worker.run_record import RunRecord
from cpm_core.image.regions import Regions
from cpm_core.particles.state import State
from cpm_core.segmentation.engine import Engine

MEGABYTES = 256
"""Memory for the timeline where nothing else is preferred."""

MEGABYTE = 2**20

_ENGINES = 3
"""Engines with different regions that are kept for taking steps anew."""


class RecordedRun:
    """Timeline and records of one run after the other."""

    def __init__(self) -> None:
        self._timeline: Timeline[RunAction] = Timeline(self._apply, MEGABYTES * MEGABYTE)
        self._engines: dict[Regions | None, Engine] = {}
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
        self._engines.clear()
        self._records.clear()

    def begin(self, engine: Engine, state: State, record: RunRecord) -> None:
        """Begin with the first state of a run."""
        self._engines = {engine.regions: engine}
        self._timeline.begin(state)
        self._records = {self.outline.branch: record}

    def record(self, action: RunAction, state: State, record: RunRecord) -> None:
        """Add a step; the recorder has it already."""
        self._timeline.record(action, state)
        self._keep(record)

    def amend(self, action: RunAction, state: State, record: RunRecord) -> None:
        """Change the state where the run stands, as by particles that join, without a step."""
        self._timeline.amend(action, state)
        self._keep(record)

    def go(self, branch: int, step: int, wanted: Callable[[], bool]) -> tuple[State, RunRecord] | None:
        """Go to another step: its state and the record up to it; None when that was no longer wanted."""
        state = self._timeline.go(branch, step, wanted)
        return None if state is None else (state, self._records[branch].until(state.step))

    def state(self, branch: int, step: int, wanted: Callable[[], bool]) -> State | None:
        """State of another step, or of the last one of a shorter branch; None when it was no longer wanted."""
        return self._timeline.state(branch, step, wanted)

    def moment(self, branch: int, step: int, wanted: Callable[[], bool]) -> tuple[State, RunRecord] | None:
        """State of another step as `go` gives it, without going there."""
        state = self._timeline.state(branch, step, wanted)
        return None if state is None else (state, self._records[branch].until(state.step))

    def rename(self, branch: int, name: str) -> None:
        """Give a branch another name."""
        self._timeline.rename(branch, name)

    def drop(self, branch: int) -> tuple[State, RunRecord]:
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

    def _apply(self, state: State, action: RunAction) -> State:
        engine = self._engines.pop(action.regions, None)
        if engine is None:
            engine = next(iter(self._engines.values())).with_regions(action.regions)
            if len(self._engines) >= _ENGINES:
                self._engines.pop(next(iter(self._engines)))
        self._engines[action.regions] = engine  # used last, and therefore let go last
        return action.apply(engine, state)
