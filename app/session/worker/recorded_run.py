"""The recorded runs on the worker thread: their timeline, and the metrics of each branch for plots."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from app.model.display.plots import RunMetrics
from app.model.document.document import Document
from app.model.document.modes import MODES
from app.model.text.language import reason
from app.session.timeline.moments import RunAction, Stepped
from app.session.timeline.stored_runs import StoredBranch, StoredRun, StoredRuns
from app.session.timeline.timeline import Branch, Outline, Timeline
from cpm_core import Method
from cpm_core.image import AnyRegions
from cpm_core.numerics import Array
from cpm_core.segmentation import MethodState
from cpm_core.shapes import Shape

MEGABYTES = 256
"""Default memory of the timeline [MB]."""

MEGABYTE = 2**20

_METHODS = 3
"""Methods with different regions that are kept for repeating steps."""

_FIRST_CAPACITY = 64
"""Steps that a record has room for at first; each branch has one."""

_NAMES = [field.name for field in fields(RunMetrics)]


class RunRecord:
    """Metrics of a run, one entry a step; arrays that it has returned are never written again."""

    def __init__(self) -> None:
        self._rows: Array = np.empty((len(_NAMES), _FIRST_CAPACITY))
        self._length = 0

    def record(self, step: int, measures: Mapping[str, float]) -> None:
        """Add one step; where the potential energy is not measured, the last value is repeated."""
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
        """A copy of the first `length` entries."""
        other = RunRecord()
        other._length = min(length, self._length)
        room = max(2 * other._length, _FIRST_CAPACITY)
        other._rows = np.empty((len(self._rows), room))
        other._rows[:, : other._length] = self._rows[:, : other._length]
        return other

    @property
    def rows(self) -> Array:
        """The figures so far, one row each, in the order of `RunMetrics`."""
        return self._rows[:, : self._length]

    @classmethod
    def of(cls, rows: Array) -> RunRecord:
        """The record of figures in rows."""
        record = cls()
        record._rows, record._length = rows.copy(), rows.shape[1]
        return record if rows.shape[1] else cls()

    def metrics(self) -> RunMetrics:
        """The metrics so far, without copying them."""
        return RunMetrics(*self._rows[:, : self._length])


@dataclass(frozen=True, slots=True)
class Begun:
    """How a run began: from this document, at last as this generation."""

    document: Document
    generation: int = 0

    def alike(self, document: Document) -> bool:
        """Whether a run from another document begins in the same way and takes the same first step."""
        return _beginning(self.document) == _beginning(document)


def _beginning(document: Document) -> tuple[object, ...]:
    image = document.image
    return (
        None if image is None else (image.spacing, image.unit),
        MODES[document.mode].method,
        document.shapes,
        document.parameters,
        document.objects.barriers,
        (document.outlines, document.outlined_surfaces) if document.mode == "skeleton" else (),
    )


class RecordedRun:
    """Timeline and metrics of all runs on an image; `make` gives the method of a run that began with a document."""

    def __init__(self, make: Callable[[Document], Method[Any]]) -> None:
        self.timeline = Timeline(self._apply, MEGABYTES * MEGABYTE)
        self._make = make
        self._methods: dict[tuple[int, AnyRegions | None], Method[Any]] = {}
        self._records: dict[int, RunRecord] = {}
        self._begun: dict[int, Begun] = {}

    @property
    def outline(self) -> Outline:
        """State of the timeline."""
        timeline = self.timeline
        branch, _ = timeline.here or (0, 0)
        taken = next((action.parameters for action in timeline.actions if isinstance(action, Stepped)), None)
        return Outline(
            timeline.branches,
            branch,
            timeline.used,
            timeline.budget,
            timeline.kept,
            taken,
            timeline.fallen,
            timeline.edition,
            timeline.steered,
            self._begun[timeline.run].generation if timeline.run else 0,
        )

    @property
    def steered(self) -> bool:
        """Whether the current run was changed between its steps, or left another run."""
        return self.timeline.here_steered

    def drawn(self) -> tuple[Shape, ...]:
        """What was drawn when the current run began."""
        run = self.timeline.run
        return self._begun[run].document.shapes if run else ()

    def clear(self) -> None:
        """Remove all runs."""
        self.timeline.clear()
        self._methods.clear()
        self._records.clear()
        self._begun.clear()

    def begin(self, method: Method[Any], state: MethodState, record: RunRecord, begun: Begun) -> None:
        """Begin a run with its first state, or go back to the beginning of the one that began in the same way."""
        run = next((known for known in self.timeline.runs if self._begun[known].alike(begun.document)), None)
        if run is None:
            run = self.timeline.begin(state)
            self._records[run] = record
        else:
            self.timeline.restart(run)
        self._begun = {known: self._begun.get(known, begun) for known in self.timeline.runs} | {run: begun}
        self._keep_method(run, method)
        known = {branch.identity for branch in self.timeline.branches}
        self._records = {branch: kept for branch, kept in self._records.items() if branch in known}

    def record(self, action: RunAction, state: MethodState, record: RunRecord) -> None:
        """Add a step that the record contains already."""
        self.timeline.record(action, state)
        self._keep(record)

    def amend(self, action: RunAction, state: MethodState, record: RunRecord, apart: bool = False) -> None:
        """Change the current state without a step, as by particles that join; `apart` on a branch of its own."""
        self.timeline.amend(action, state, apart)
        self._keep(record)

    def go(self, branch: int, step: int, wanted: Callable[[], bool]) -> tuple[MethodState, RunRecord] | None:
        """Go to another step: its state and the record up to it; None when it was no longer wanted."""
        state = self.timeline.go(branch, step, wanted)
        return None if state is None else (state, self._records[branch].until(state.step))

    def moment(self, branch: int, step: int, wanted: Callable[[], bool]) -> tuple[MethodState, RunRecord] | None:
        """State of another step and the record up to it, as `go` gives them, without going there."""
        state = self.timeline.state(branch, step, wanted)
        return None if state is None else (state, self._records[branch].until(state.step))

    def drop(self, branch: int) -> tuple[MethodState, RunRecord] | None:
        """Remove a branch: the current state after that, and the record up to it; None where there is none."""
        self.timeline.drop(branch)
        here = self.timeline.here
        return None if here is None else self.go(*here, lambda: True)

    # Stored runs

    def stored(self, drawn: Mapping[int, Counter[Hashable]]) -> StoredRuns:
        """All runs for a session; `drawn` are the sources of the particles of each, by its generation."""
        runs = []
        for run in self.timeline.runs:
            begun = self._begun[run]
            branches = tuple(map(self._stored_branch, (one for one in self.timeline.branches if one.run == run)))
            runs.append(StoredRun(begun.document, drawn.get(begun.generation, begun.document.sources), branches))
        here = self.timeline.here
        places = [(of.number, of.first + len(of.steps) - 1) for each in runs for of in each.branches]
        known = {place: self.timeline.kept_state(*place) for place in {*places, *([here] if here else [])}}
        return StoredRuns(tuple(runs), here, {place: state for place, state in known.items() if state is not None})

    def _stored_branch(self, branch: Branch) -> StoredBranch:
        rows = self._records.get(branch.identity, RunRecord()).rows.copy()
        steps = self.timeline.own_actions(branch.identity)
        return StoredBranch(
            branch.identity, branch.name, branch.renamed, branch.parent, branch.first, steps, branch.scales, rows
        )

    def restore(self, stored: StoredRuns, first: Callable[[Method[Any], Document], MethodState]) -> str:
        """Take over the runs of a session; `first` gives the first state of one. Returns what one failed at, if any."""
        self.clear()
        branches: list[StoredBranch] = []
        begun: dict[int, MethodState] = {}
        fault = ""
        for generation, run in enumerate(stored.runs, 1):
            number = run.branches[0].number
            try:
                method = self._make(run.document)
                begun[number] = first(method, run.document)
            except ValueError as error:
                fault = fault or reason(error)
                continue
            self._begun[number] = Begun(run.document, -generation)
            self._keep_method(number, method)
            for branch in run.branches:
                branches.append(branch)
                self._records[branch.number] = RunRecord.of(branch.figures)
        known = {branch.number for branch in branches}
        self.timeline.restore(branches, begun, {at: state for at, state in stored.states.items() if at[0] in known})
        return fault

    def _keep(self, record: RunRecord) -> None:
        """Keep the longest record of a branch."""
        here = self.timeline.here
        assert here is not None
        known = self._records.get(here[0])
        if known is None or len(record) >= len(known):
            self._records[here[0]] = record

    def method(self, run: int, regions: AnyRegions | None) -> Method[Any]:
        """The method of a run, in these regions."""
        method = self._methods.pop((run, regions), None)
        if method is None:
            method = next((known for (of, _), known in self._methods.items() if of == run), None)
            method = (method or self._make(self._begun[run].document)).with_regions(regions)
        self._keep_method(run, method)
        return method

    def _keep_method(self, run: int, method: Method[Any]) -> None:
        """Keep a method as the one that is used last, and therefore removed last; its fields take up memory."""
        self._methods.pop((run, method.regions), None)
        self._methods[run, method.regions] = method
        while len(self._methods) > _METHODS:
            self._methods.pop(next(iter(self._methods)))

    def _apply(self, run: int, state: MethodState, action: RunAction) -> MethodState:
        return action.apply(self.method(run, action.regions), state)  # type: ignore[no-any-return]
