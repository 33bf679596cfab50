"""The timeline: every step of every run can be visited, and a run can continue from any of them.

A step depends only on the state before it and on its action. So the actions of all steps are kept, and as many states
as memory allows; any other state is recomputed from the nearest one before it, identical to the bit. Neither threads
nor the window are known here.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import takewhile
from typing import Any

from cpm_app.model.display.plots import RunMetrics
from cpm_app.model.document.document import Document
from cpm_app.model.document.modes import MODES
from cpm_app.model.text.language import explain_error, tr
from cpm_app.session.timeline.moments import BranchStep, KeptStates, Moment, RunAction, RunRecord, Stepped
from cpm_app.session.timeline.stored_runs import Branch, StoredBranch, StoredRun, StoredRuns
from cpm_core import Method, Parameters
from cpm_core.image import AnyRegions
from cpm_core.numerics.types import Texts, record
from cpm_core.segmentation import MethodState
from cpm_core.shapes import Shape

MOST_RUNS = 12
"""Largest number of runs that are kept."""

MEGABYTE = 2**20
"""Bytes of a megabyte."""

_DEFAULT_STATE_BUDGET = 256 * MEGABYTE
"""Largest size of the kept states by default [bytes]."""

_MAX_CACHED_METHODS = 3
"""Number of methods with different regions that are kept for repeating steps."""


@record
class Outline:
    """State of the timeline, as the window shows it.

    Attributes
    ----------
    branches : tuple of Branch
        The branches, the oldest first; the same tuple as long as only the last step of `branch` changes.
    branch : int
        The current branch, 0 before there is one.
    parameters : Parameters or None
        Parameters of the current step; None for the first.
    fallen : tuple of str
        Names of the runs that were removed to make room.
    edition : int
        Changes whenever something is recorded, renamed or removed.
    steered : bool
        Whether there is more than a single run without interventions.
    began : int
        Generation of the current run, 0 before there is one.
    """

    branches: tuple[Branch, ...] = ()
    branch: int = 0
    parameters: Parameters | None = None
    fallen: Texts = ()
    edition: int = 0
    steered: bool = False
    began: int = 0


@dataclass(eq=False)
class _Line:
    """A branch with the last node of each step, from the first step of its run; branches share their common beginning.

    `scales` are first steps and numbers of its scales, `record` has its figures for plots; `steered` is whether its
    state or its parameters were changed between steps.
    """

    identity: int
    name: str
    run: int
    path: list[Moment]
    scales: list[tuple[int, int]]
    steered: bool = False
    renamed: bool = False
    record: RunRecord = field(default_factory=RunRecord)

    @property
    def last(self) -> int:
        return len(self.path) - 1

    def at(self, step: int) -> Moment:
        """Return the node of a step, or of the nearest one."""
        return self.path[min(max(step, 0), self.last)]

    def common(self, other: _Line) -> int:
        """Count the nodes that it has in common with another branch."""
        most = range(min(len(self.path), len(other.path)))
        return bisect_left(most, True, key=lambda at: self.path[at] is not other.path[at])

    def scales_until(self, step: int) -> list[tuple[int, int]]:
        return [mark for mark in self.scales if mark[0] <= step]


_NO_BRANCH = _Line(0, "", 0, [], [])
"""The branch that a run is on before it has begun."""


class Timeline:
    """The steps of all runs on an image and their branches, and the current one.

    `make` returns the method of a run that began with a document; states take at most `budget` bytes.
    """

    def __init__(self, make: Callable[[Document], Method[Any]], budget: int = _DEFAULT_STATE_BUDGET) -> None:
        self.edition = 0
        """Changes whenever something is recorded, renamed or removed."""
        self._kept = KeptStates(budget)
        self._lines: dict[int, _Line] = {}
        self._line = _NO_BRANCH
        self._step = 0
        self._numbered, self._named = 0, [0, 0]
        self._branches: tuple[Branch, ...] | None = None
        self._fallen: Texts = ()
        self._begun: dict[int, tuple[Document, int]] = {}

        @lru_cache(_MAX_CACHED_METHODS)
        def method_of_run(run: int, regions: AnyRegions | None) -> Method[Any]:
            made = make(self._begun[run][0])
            return made if made.regions == regions else made.with_regions(regions)

        self.method = method_of_run
        """Returns the method of a run, by the number of the run, in some regions."""

    # State

    def limit(self, budget: int) -> None:
        """Set the largest size of the kept states [bytes]."""
        self._kept.budget = budget
        self._make_room()

    @property
    def outline(self) -> Outline:
        """State of the timeline, as the window shows it; the current branch may have become longer meanwhile."""
        if self._branches is None:
            self._branches = tuple(map(self._branch, self._lines.values()))
        actions = () if self._kept.here is None else self._kept.here.actions
        return Outline(
            self._branches,
            self._line.identity,
            next((action.parameters for action in actions if isinstance(action, Stepped)), None),
            self._fallen,
            self.edition,
            len(self._lines) > 1 or any(line.steered for line in self._lines.values()),
            self._begun[self.run][1] if self.run else 0,
        )

    @property
    def here(self) -> BranchStep | None:
        """Current branch and step; None before a run has begun."""
        return (self._line.identity, self._step) if self.run else None

    @property
    def run(self) -> int:
        """Number of the current run, 0 before there is one."""
        return self._line.run

    @property
    def steered(self) -> bool:
        """Whether the current run was changed between its steps, or left another run."""
        return self._line.steered

    @property
    def drawn(self) -> tuple[Shape, ...]:
        """The shapes when the current run began."""
        return self._begun[self.run][0].shapes if self.run else ()

    def run_of(self, branch: int) -> int:
        """Return the number of the run that a branch belongs to."""
        return self._known(branch).run

    def state(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """Return the state of a step, as `go` does, without going there."""
        moment, missing = self._known(branch).at(step), []
        while (state := self._kept.get(moment)) is None:
            missing.append(moment)
            assert moment.previous is not None
            moment = moment.previous
        for moment in reversed(missing):
            if not wanted():
                return None
            assert moment.action is not None
            state = moment.action.apply(self.method(moment.run, moment.action.regions), state)
            self._kept.put(moment, state)
        return state

    def metrics(self, branch: int, step: int) -> RunMetrics:
        """Return the figures of a branch up to a step."""
        return self._known(branch).record.metrics(step)

    # Recording

    def begin(self, state: MethodState, document: Document, generation: int = 0) -> None:
        """Begin a run with its first state, or go back to the beginning of one that began in the same way.

        The window knows it by its `generation`. Runs without a step are removed.
        """
        beginning = _beginning(document)
        run = next((run for run, (begun, _) in self._begun.items() if _beginning(begun) == beginning), 0)
        if run:
            self._begun[run] = document, generation
            self.go(self._root(run).identity, 0)
        else:
            for known in tuple(self._begun):
                lines = [line for line in self._lines.values() if line.run == known]
                if len(lines) == 1 and not lines[0].renamed and [at.previous for at in lines[0].path] == [None]:
                    self._remove_run(known)
            run = self._numbered + 1
            self._begun[run] = document, generation
            self.edition += 1
            self._arrive(self._open([Moment(run, 0)], [(0, state.scale)], run, tr("Run {number}")), state)

    def record(self, action: RunAction, state: MethodState, measures: Mapping[str, float]) -> None:
        """Add the step after the current one, with its figures.

        A new branch begins where the action differs from the recorded one; otherwise the run follows the branch.
        """
        line, moment, at = self._line, self._kept.here, state.step
        assert moment is not None
        following = (other for other in (line, *self._lines.values()) if len(other.path) > at)
        same = (one for one in following if one.path[at].previous is moment and one.path[at].action == action)
        known = next(same, None)
        if known is None:
            if self._step < line.last:
                line = self._fork(line)
                line.path.append(moment)
            line.path.append(Moment(line.run, at, moment, action))
            line.steered = line.steered or action != line.path[1].action
            if state.scale != line.scales[-1][1]:
                line.scales.append((at, state.scale))
                self._branches = None
            self.edition += 1
        (known or line).record.record(at, measures)
        self._arrive(known or line, state)

    def amend(self, action: RunAction, state: MethodState, apart: bool = False) -> None:
        """Change the current state without a step.

        If other steps have followed from it, the change begins a new branch. It also does so if `apart`, so that the
        state before it can be visited again.
        """
        line, moment = self._line, self._kept.here
        assert moment is not None
        others = (other.at(self._step) for other in self._lines.values() if other is not line)
        if apart or self._step < line.last or moment in others:
            line = self._fork(line)
        else:
            line.path.pop()
            line.steered = True
            if moment.previous is not None:
                self._kept.drop(moment)
        line.path.append(Moment(line.run, self._step, moment, action))
        self.edition += 1
        self._arrive(line, state)

    # Going

    def go(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """Go to a step, or to the nearest one of its branch, and return its state, exactly as it was.

        `wanted` is called between steps that have to be repeated; if it returns False, nothing changes and the
        result is None. Raises ValueError if there is no such branch.
        """
        state = self.state(branch, step, wanted)
        if state is not None:
            self._branches = None
            self._arrive(self._lines[branch], state)
        return state

    def leave(self) -> None:
        """Leave the current run, which is kept, so that another one can begin."""
        self._line, self._step, self._kept.here, self._branches = _NO_BRANCH, 0, None, None

    # Branches

    def rename(self, branch: int, name: str) -> None:
        """Rename a branch; an empty name changes nothing."""
        line = self._known(branch)
        if name.strip():
            line.name, line.renamed = name.strip(), True
            self._change()

    def drop(self, branch: int) -> MethodState | None:
        """Remove a branch, but not the steps that it shares with others; return the current state after that.

        If the run is on a removed step, it goes back to where that branch began, or to the end of the previous run.
        Raises ValueError if there is no such branch, or no other one.
        """
        line = self._known(branch)
        if len(self._lines) == 1:
            raise ValueError(tr("The only run cannot be deleted."))
        rest = [other for other in self._lines.values() if other.run == line.run and other is not line]
        if any(not other.common(rest[0]) and rest[0].path[0] not in other.path[0].of_step for other in rest):
            raise ValueError(
                tr("{name} cannot be deleted: several branches begin with its step {step}.", name=line.name, step=0)
            )
        del self._lines[branch]
        if self._line is line and rest:
            other = max(rest, key=line.common)
            self.go(other.identity, min(self._step, max(line.common(other) - 1, 0)))
        elif self._line is line:
            runs = tuple(self._begun)
            before = self._root(runs[runs.index(line.run) - 1])
            self.go(before.identity, before.last)
        self._kept.keep_only(line.run, {moment for other in rest for moment in other.path})
        if not rest:
            del self._begun[line.run]
        self._change()
        return None if self.here is None else self.state(*self.here)

    def clear(self) -> None:
        """Remove everything."""
        self.leave()
        self._numbered, self._named, self._fallen = 0, [0, 0], ()
        self._lines, self._begun = {}, {}
        self.method.cache_clear()
        self._kept.clear()
        self.edition += 1

    # Stored runs

    def stored(self, drawn: Mapping[int, Counter[Hashable]]) -> StoredRuns:
        """Return all runs for a session; `drawn` are the sources of the particles of each, by its generation."""
        runs = []
        for run, (document, generation) in self._begun.items():
            branches = tuple(self._stored(line) for line in self._lines.values() if line.run == run)
            runs.append(StoredRun(document, drawn.get(generation, document.start_counts), branches))
        places = {(line.identity, line.last) for line in self._lines.values()} | ({self.here} if self.here else set())
        kept = ((place, self._kept.get(self._lines[place[0]].at(place[1]))) for place in places)
        return StoredRuns(tuple(runs), self.here, {place: state for place, state in kept if state is not None})

    def _stored(self, line: _Line) -> StoredBranch:
        """Return a branch with its own actions, from the step at which it leaves its parent."""
        branch = self._branch(line)
        steps = [moment.actions for moment in line.path[branch.first :]]
        if branch.parent is not None:
            steps[0] = steps[0][len(self._lines[branch.parent].at(branch.first).actions) :]
        return StoredBranch(branch, tuple(steps), line.record.rows)

    def restore(self, stored: StoredRuns, first: Callable[[Method[Any], Document], MethodState]) -> str:
        """Take over the runs of a session; return the first error, or "".

        `first` returns the first state of a run. The number of a run is the number of its first branch; generations
        are counted from -1 down.
        """
        self.clear()
        fault = ""
        for generation, run in enumerate(stored.runs, 1):
            root = Moment(run.branches[0].branch.identity, 0)
            self._begun[root.run] = run.document, -generation
            try:
                self._kept.put(root, first(self.method(root.run, run.document.regions), run.document))
            except ValueError as error:
                fault = fault or explain_error(error)
                del self._begun[root.run]
                self.method.cache_clear()  # another run may get its number
                continue
            for branch in run.branches:
                self._adopt(branch, root)
        for (number, step), state in stored.states.items():
            if number in self._lines:
                self._kept.put(self._lines[number].at(step), state)
        self._make_room()
        return fault

    def _adopt(self, stored: StoredBranch, root: Moment) -> None:
        """Add a branch of a session."""
        branch, path, scales = stored.branch, [root], list(stored.branch.scales)
        if branch.parent is not None:
            parent = self._known(branch.parent)
            path, scales = parent.path[: branch.first + 1], parent.scales_until(branch.first) + scales
        for step, actions in enumerate(stored.steps, branch.first):
            moment = path[-1] if step > branch.first else path.pop()
            for action in actions:
                moment = Moment(root.run, step, moment, action)
            path.append(moment)
        kind, number = branch.parent is not None, branch.name.rpartition(" ")[2]
        steered = kind or bool(path[0].actions) or any(at.actions != path[1].actions for at in path[1:])
        self._lines[branch.identity] = _Line(
            branch.identity, branch.name, root.run, path, scales, steered, branch.renamed, RunRecord(stored.figures)
        )
        self._numbered = max(self._numbered, branch.identity)
        self._named[kind] = max(self._named[kind] + 1, int(number) if number.isdecimal() else 0)

    # Internal

    def _known(self, branch: int) -> _Line:
        if branch not in self._lines:
            raise ValueError(tr("Branch {number} no longer exists.", number=branch))
        return self._lines[branch]

    def _root(self, run: int) -> _Line:
        """Return the oldest branch of a run."""
        return next(line for line in self._lines.values() if line.run == run)

    def _branch(self, line: _Line) -> Branch:
        """Describe a branch for the window.

        Its parent is the older branch of its run that it shares the most nodes with.
        """
        older = takewhile(lambda other: other is not line, self._lines.values())
        parent = max((other for other in older if other.run == line.run), key=line.common, default=None)
        scales, first = line.scales, 0
        if parent is not None:
            at = line.common(parent)
            both = at < min(len(line.path), len(parent.path))
            first = at if both and parent.path[at] in line.path[at].of_step else at - 1
            scales = [mark for mark in scales if mark[0] > first]
        leaves = None if parent is None else parent.identity
        return Branch(line.identity, line.name, leaves, first, line.last, tuple(scales), line.run, line.renamed)

    def _open(self, path: list[Moment], scales: list[tuple[int, int]], run: int, name: str) -> _Line:
        """Add a branch; a run is numbered like its first branch."""
        self._numbered += 1
        branches = run != self._numbered
        self._named[branches] += 1
        name = name.format(number=self._named[branches])
        line = self._lines[self._numbered] = _Line(self._numbered, name, run, path, scales, steered=branches)
        self._branches = None
        return line

    def _fork(self, line: _Line) -> _Line:
        """Begin a branch that shares the steps before the current one with another branch."""
        scales = line.scales_until(self._step)
        fork = self._open(line.path[: self._step], scales, line.run, tr("Branch {number}"))
        fork.record = line.record.until(self._step)
        return fork

    def _arrive(self, line: _Line, state: MethodState) -> None:
        """Make the step of a branch with this state the current one."""
        if line is not self._line:
            self._branches = None
        moment = line.at(state.step)
        self._line, self._step, self._kept.here = line, state.step, moment
        self._kept.put(moment, state)
        self._make_room()

    def _change(self) -> None:
        """Note that the branches have changed."""
        self.edition += 1
        self._branches = None

    def _remove_run(self, run: int) -> None:
        if self.run == run:
            self.leave()
        del self._begun[run]
        self._lines = {branch: line for branch, line in self._lines.items() if line.run != run}
        self._kept.keep_only(run, set())
        self._change()

    def _make_room(self) -> None:
        """Remove the oldest runs until the others fit, those named by the user last; never the newest one."""
        self._kept.make_room()
        while self._kept.used > self._kept.budget or len(self._begun) > MOST_RUNS:
            roots = [self._root(run) for run in tuple(self._begun)[:-1]]
            oldest = min((one for one in roots if one.run != self.run), key=lambda one: one.renamed, default=None)
            if oldest is None:
                return
            self._fallen = (*self._fallen, oldest.name)
            self._remove_run(oldest.run)


def _beginning(document: Document) -> tuple[object, ...]:
    """Return everything that decides how a run begins and takes its first step."""
    image = document.image
    return (
        None if image is None else (image.spacing, image.unit),
        MODES[document.mode].method,
        document.shapes,
        document.parameters,
        document.objects.barriers,
        (document.outlines, document.outlined_surfaces) if document.mode == "skeleton" else (),
    )
