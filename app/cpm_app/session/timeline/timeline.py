"""The timeline: every step of every run can be visited, and a run can continue from any of them.

A step depends only on the state before it and on its action. So the actions of all steps are kept, and as many states
as memory allows; any other state is recomputed from the nearest one before it, identical to the bit. Neither threads
nor the window are known here.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable, Mapping
from functools import lru_cache
from typing import Any

from cpm_app.model.display.plots import RunMetrics
from cpm_app.model.document.document import Document
from cpm_app.model.document.modes import MODES
from cpm_app.model.text.language import tr
from cpm_app.session.timeline.branches import (
    NO_BRANCH,
    Branch,
    StoredRun,
    StoredRuns,
    TimelineBranch,
    describe_branches,
)
from cpm_app.session.timeline.timeline_nodes import (
    BranchStep,
    RunAction,
    StateCache,
    StepAction,
    TimelineNode,
)
from cpm_core import Method, Parameters
from cpm_core.image import AnyRegions
from cpm_core.numerics.types import Texts, record
from cpm_core.segmentation import MethodState
from cpm_core.shapes import Shape

MAX_TIMELINE_RUNS = 12
"""Largest number of runs that are kept."""

BYTES_PER_MEGABYTE = 2**20
"""Bytes of a megabyte."""

_DEFAULT_STATE_BUDGET = 256 * BYTES_PER_MEGABYTE
"""Largest size of the kept states by default [bytes]."""

_MAX_CACHED_METHODS = 3
"""Number of methods with different regions that are kept for repeating steps."""


@record
class TimelineState:
    """State of the timeline, as the window shows it.

    Attributes
    ----------
    branches : tuple of TimelineBranch
        The branches, the oldest first; the same tuple as long as only the last step of `branch` changes.
    branch : int
        The current branch, 0 before there is one.
    parameters : Parameters or None
        Parameters of the current step; None for the first.
    dropped_runs : tuple of str
        Names of the runs that were removed to make room.
    edition : int
        Changes whenever something is recorded, renamed or removed.
    steered : bool
        Whether there is more than a single run without interventions.
    run_generation : int
        Number by which the window knows the current run, 0 before there is one.
    """

    branches: tuple[TimelineBranch, ...] = ()
    branch: int = 0
    parameters: Parameters | None = None
    dropped_runs: Texts = ()
    edition: int = 0
    steered: bool = False
    run_generation: int = 0


EMPTY_TIMELINE = TimelineState()
"""The timeline before there is a run."""


class Timeline:
    """The steps of all runs on an image and their branches, and the current one.

    `make` returns the method of a run that began with a document; states take at most `budget` bytes.
    """

    def __init__(self, make: Callable[[Document], Method[Any]], budget: int = _DEFAULT_STATE_BUDGET) -> None:
        self.edition = 0
        """Changes whenever something is recorded, renamed or removed."""
        self._states = StateCache(budget)
        self._branches_by_number: dict[int, Branch] = {}
        self._current_branch = NO_BRANCH
        self._step = 0
        self._numbered = 0
        """Number of the newest branch."""
        self._named = [0, 0]
        """Largest numbers in the names of runs and of branches that leave another one."""
        self._shown_branches: tuple[TimelineBranch, ...] | None = None
        self._dropped_runs: Texts = ()
        self._begun: dict[int, tuple[Document, int]] = {}

        @lru_cache(_MAX_CACHED_METHODS)
        def method_of_run(run: int, regions: AnyRegions | None) -> Method[Any]:
            made = make(self._begun[run][0])
            return made if made.regions == regions else made.with_regions(regions)

        self.method_of_run = method_of_run
        """Returns the method of a run, by the number of the run, in some regions."""

    # State

    def set_budget(self, budget: int) -> None:
        """Set the largest size of the kept states [bytes]."""
        self._states.budget = budget
        self._evict_runs()

    @property
    def timeline_state(self) -> TimelineState:
        """State of the timeline, as the window shows it; the current branch may have become longer meanwhile."""
        if self._shown_branches is None:
            self._shown_branches = describe_branches(self._branches_by_number.values())
        actions = () if self._states.current is None else self._states.current.actions
        return TimelineState(
            self._shown_branches,
            self._current_branch.identity,
            next((action.parameters for action in actions if isinstance(action, StepAction)), None),
            self._dropped_runs,
            self.edition,
            len(self._branches_by_number) > 1 or any(line.steered for line in self._branches_by_number.values()),
            self._begun[self.current_run][1] if self.current_run else 0,
        )

    @property
    def current_step(self) -> BranchStep | None:
        """Current branch and step; None before a run has begun."""
        return (self._current_branch.identity, self._step) if self.current_run else None

    @property
    def current_run(self) -> int:
        """Number of the current run, 0 before there is one."""
        return self._current_branch.run

    @property
    def steered(self) -> bool:
        """Whether the current branch was changed between its steps, or left another branch."""
        return self._current_branch.steered

    @property
    def starting_shapes(self) -> tuple[Shape, ...]:
        """The shapes when the current run began."""
        return self._begun[self.current_run][0].shapes if self.current_run else ()

    def run_of(self, branch: int) -> int:
        """Return the number of the run that a branch belongs to."""
        return self._get_branch(branch).run

    def compute_state(self, branch: int, step: int, is_wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """Return the state of a step, as `go_to` does, without going there."""
        node, missing = self._get_branch(branch).node_at(step), []
        while (state := self._states.get(node)) is None:
            missing.append(node)
            assert node.previous is not None
            node = node.previous
        for node in reversed(missing):
            if not is_wanted():
                return None
            assert node.action is not None
            state = node.action.apply_to(self.method_of_run(node.run, node.action.regions), state)
            self._states.put(node, state)
        return state

    def metrics_until(self, branch: int, step: int) -> RunMetrics:
        """Return the figures of a branch up to a step."""
        return self._get_branch(branch).figures.metrics_until(step)

    # Recording

    def begin_run(self, state: MethodState, document: Document, generation: int = 0) -> None:
        """Begin a run with its first state, or go back to the beginning of one that began in the same way.

        The window knows it by its `generation`. Runs without a step are removed.
        """
        beginning = _beginning_key(document)
        run = next((run for run, (begun, _) in self._begun.items() if _beginning_key(begun) == beginning), 0)
        if run:
            self._begun[run] = document, generation
            self.go_to(self._first_branch(run).identity, 0)
        else:
            for known in tuple(self._begun):
                lines = [line for line in self._branches_by_number.values() if line.run == known]
                if len(lines) == 1 and not lines[0].renamed and [at.previous for at in lines[0].nodes] == [None]:
                    self._remove_run(known)
            run = self._numbered + 1
            self._begun[run] = document, generation
            self.edition += 1
            self._set_current(
                self._add_branch([TimelineNode(run, 0)], [(0, state.scale)], run, tr("Run {number}")), state
            )

    def record_step(self, action: RunAction, state: MethodState, measures: Mapping[str, float]) -> None:
        """Add the step after the current one, with its figures.

        A new branch begins where the action differs from the recorded one; otherwise the run follows the branch.
        """
        line, node, at = self._current_branch, self._states.current, state.step
        assert node is not None
        following = (other for other in (line, *self._branches_by_number.values()) if len(other.nodes) > at)
        same = (one for one in following if one.nodes[at].previous is node and one.nodes[at].action == action)
        known = next(same, None)
        if known is None:
            if self._step < line.last:
                line = self._fork_branch(line)
                line.nodes.append(node)
            line.nodes.append(TimelineNode(line.run, at, node, action))
            line.steered = line.steered or action != line.nodes[1].action
            if state.scale != line.scales[-1][1]:
                line.scales.append((at, state.scale))
                self._shown_branches = None
            self.edition += 1
        (known or line).figures.add_step(at, measures)
        self._set_current(known or line, state)

    def amend_state(self, action: RunAction, state: MethodState, on_own_branch: bool = False) -> None:
        """Change the current state without a step.

        If other steps have followed from it, the change begins a new branch. It also does so if `on_own_branch`, so
        that the state before it can be visited again.
        """
        line, node = self._current_branch, self._states.current
        assert node is not None
        others = (other.node_at(self._step) for other in self._branches_by_number.values() if other is not line)
        if on_own_branch or self._step < line.last or node in others:
            line = self._fork_branch(line)
        else:
            line.nodes.pop()
            line.steered = True
            if node.previous is not None:
                self._states.drop(node)
        line.nodes.append(TimelineNode(line.run, self._step, node, action))
        self.edition += 1
        self._set_current(line, state)

    # Visiting steps

    def go_to(self, branch: int, step: int, is_wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """Go to a step, or to the nearest one of its branch, and return its state, exactly as it was.

        `is_wanted` is called between steps that have to be repeated; if it returns False, nothing changes and the
        result is None. Raises ValueError if there is no such branch.
        """
        state = self.compute_state(branch, step, is_wanted)
        if state is not None:
            self._shown_branches = None
            self._set_current(self._branches_by_number[branch], state)
        return state

    def leave_run(self) -> None:
        """Leave the current run, which is kept, so that another one can begin."""
        self._current_branch, self._step, self._states.current, self._shown_branches = NO_BRANCH, 0, None, None

    # Branches

    def rename_branch(self, branch: int, name: str) -> None:
        """Rename a branch; an empty name changes nothing."""
        line = self._get_branch(branch)
        if name.strip():
            line.name, line.renamed = name.strip(), True
            self._mark_changed()

    def remove_branch(self, branch: int) -> MethodState | None:
        """Remove a branch, but not the steps that it shares with others; return the current state after that.

        If the run is on a removed step, it goes back to where that branch began, or to the end of the previous run.
        Raises ValueError if there is no such branch, or no other one.
        """
        line = self._get_branch(branch)
        if len(self._branches_by_number) == 1:
            raise ValueError(tr("The only run cannot be deleted."))
        rest = [other for other in self._branches_by_number.values() if other.run == line.run and other is not line]
        del self._branches_by_number[branch]
        if self._current_branch is line and rest:
            other = max(rest, key=line.count_common_nodes)
            self.go_to(other.identity, min(self._step, max(line.count_common_nodes(other) - 1, 0)))
        elif self._current_branch is line:
            runs = tuple(self._begun)
            before = self._first_branch(runs[runs.index(line.run) - 1])
            self.go_to(before.identity, before.last)
        self._states.keep_only(line.run, {node for other in rest for node in other.nodes})
        if not rest:
            del self._begun[line.run]
        self._mark_changed()
        return None if self.current_step is None else self.compute_state(*self.current_step)

    def clear(self) -> None:
        """Remove everything."""
        self.leave_run()
        self._numbered, self._named, self._dropped_runs = 0, [0, 0], ()
        self._branches_by_number, self._begun = {}, {}
        self.method_of_run.cache_clear()
        self._states.clear()
        self.edition += 1

    # Stored runs

    def to_stored_runs(
        self, sources: Mapping[int, Counter[Hashable]], parameters: Parameters | None = None
    ) -> StoredRuns:
        """Return all runs for a session; `sources` are the sources of the particles of each, by its generation."""
        runs = tuple(
            StoredRun(
                document,
                sources.get(generation, document.start_counts),
                tuple(line for line in self._branches_by_number.values() if line.run == run),
            )
            for run, (document, generation) in self._begun.items()
        )
        steps = {(line.identity, line.last) for line in self._branches_by_number.values()}
        if self.current_step is not None:
            steps.add(self.current_step)
        kept = {at: self._states.get(self._branches_by_number[at[0]].node_at(at[1])) for at in steps if at[1]}
        states = {at: state for at, state in kept.items() if state is not None}
        return StoredRuns(runs, self.current_step, parameters, states)

    def restore_runs(self, stored: StoredRuns, first: Callable[[Method[Any], Document], MethodState]) -> None:
        """Take over the runs of a session; raise ValueError if one cannot begin.

        `first` returns the first state of a run. Generations are counted from -1 down.
        """
        self.clear()
        for generation, run in enumerate(stored.runs, 1):
            number = run.branches[0].run
            self._begun[number] = run.document, -generation
            method = self.method_of_run(number, run.document.regions)
            self._states.put(run.branches[0].nodes[0].nodes_of_step[0], first(method, run.document))
            for line in run.branches:
                self._branches_by_number[line.identity] = line
                self._numbered = max(self._numbered, line.identity)
                forked, named = line.identity != number, line.name.rpartition(" ")[2]
                self._named[forked] = max(self._named[forked] + 1, int(named) if named.isdecimal() else 0)
        for (number, step), state in stored.states.items():
            self._states.put(self._branches_by_number[number].node_at(step), state)
        self._evict_runs()

    # Internal

    def _get_branch(self, branch: int) -> Branch:
        if branch not in self._branches_by_number:
            raise ValueError(tr("Branch {number} no longer exists.", number=branch))
        return self._branches_by_number[branch]

    def _first_branch(self, run: int) -> Branch:
        """Return the oldest branch of a run."""
        return next(line for line in self._branches_by_number.values() if line.run == run)

    def _add_branch(self, path: list[TimelineNode], scales: list[tuple[int, int]], run: int, name: str) -> Branch:
        """Add a branch; a run is numbered like its first branch."""
        self._numbered += 1
        forked = run != self._numbered
        self._named[forked] += 1
        name = name.format(number=self._named[forked])
        line = self._branches_by_number[self._numbered] = Branch(
            self._numbered, name, run, path, scales, steered=forked
        )
        self._shown_branches = None
        return line

    def _fork_branch(self, line: Branch) -> Branch:
        """Begin a branch that shares the steps before the current one with another branch."""
        scales = line.scales_until(self._step)
        fork = self._add_branch(line.nodes[: self._step], scales, line.run, tr("Branch {number}"))
        fork.figures = line.figures.copy_until(self._step)
        return fork

    def _set_current(self, line: Branch, state: MethodState) -> None:
        """Make the step of a branch with this state the current one."""
        if line is not self._current_branch:
            self._shown_branches = None
        node = line.node_at(state.step)
        self._current_branch, self._step, self._states.current = line, state.step, node
        self._states.put(node, state)
        self._evict_runs()

    def _mark_changed(self) -> None:
        """Note that the branches have changed."""
        self.edition += 1
        self._shown_branches = None

    def _remove_run(self, run: int) -> None:
        if self.current_run == run:
            self.leave_run()
        del self._begun[run]
        self._branches_by_number = {
            branch: line for branch, line in self._branches_by_number.items() if line.run != run
        }
        self._states.keep_only(run, set())
        self._mark_changed()

    def _evict_runs(self) -> None:
        """Remove the oldest runs until the others fit, those named by the user last; never the newest one."""
        self._states.evict_states()
        while self._states.used > self._states.budget or len(self._begun) > MAX_TIMELINE_RUNS:
            roots = [self._first_branch(run) for run in tuple(self._begun)[:-1]]
            oldest = min(
                (one for one in roots if one.run != self.current_run), key=lambda one: one.renamed, default=None
            )
            if oldest is None:
                return
            self._dropped_runs = (*self._dropped_runs, oldest.name)
            self._remove_run(oldest.run)


def _beginning_key(document: Document) -> tuple[object, ...]:
    """Return everything that decides how a run begins and takes its first step."""
    image = document.image
    return (
        None if image is None else (image.spacing, image.unit),
        MODES[document.mode].method,
        document.shapes,
        document.parameters,
        document.objects.barriers,
        (document.outlines, document.outlined_bodies) if document.mode == "skeleton" else (),
    )
