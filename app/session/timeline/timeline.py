"""The timeline: every step of every run can be gone to, and a run can continue from any of them.

A step depends only on the state before it and on its action. So the actions of all steps are kept, and as many states
as memory allows; any other state is computed again from the nearest one before it, bit for bit the same. Threads and
the window are not known here.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile

from app.model.text.language import tr
from app.session.timeline.moments import BranchStep, KeptStates, Moment, RunAction
from app.session.timeline.stored_runs import StoredBranch
from cpm_core import Parameters
from cpm_core.segmentation import MethodState

MOST_RUNS = 12
"""Largest number of runs that are kept."""

Apply = Callable[[int, MethodState, RunAction], MethodState]
"""Gives the next state of a run from a state and an action, always the same one."""


@dataclass(frozen=True, slots=True)
class Branch:
    """A run, or a branch of one, as the window shows it.

    Attributes
    ----------
    identity : int
        Its number, unique on the timeline.
    name : str
        Name that is shown.
    parent : int or None
        The branch that it leaves; None for a run.
    first, last : int
        Step at which it leaves its parent, and the last one recorded.
    scales : tuple of tuple of int
        First steps and numbers of the scales among its own steps.
    run : int
        Number of the run that it belongs to.
    renamed : bool
        Whether the user has named it.
    """

    identity: int
    name: str
    parent: int | None
    first: int
    last: int
    scales: tuple[tuple[int, int], ...] = ()
    run: int = 0
    renamed: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Outline:
    """State of the timeline, as the window shows it.

    Attributes
    ----------
    branches : tuple of Branch
        The oldest first; the same tuple as long as nothing but the last step of `branch` has changed.
    branch : int
        The current branch, 0 before there is one.
    used, budget : int
        Bytes that its states take, and their maximum.
    kept : int
        Number of states that are kept; the others are computed again.
    parameters : Parameters or None
        Parameters of the current step; None for the first.
    fallen : tuple of str
        Names of the runs that were removed to make room.
    edition : int
        Changes whenever something is recorded, renamed or removed.
    steered : bool
        Whether there is more than one run that went on without a change to its end.
    began : int
        Generation with which the current run began, 0 before there is one.
    """

    branches: tuple[Branch, ...] = ()
    branch: int = 0
    used: int = 0
    budget: int = 0
    kept: int = 0
    parameters: Parameters | None = None
    fallen: tuple[str, ...] = ()
    edition: int = 0
    steered: bool = False
    began: int = 0


@dataclass(eq=False, slots=True)
class _Line:
    """A branch with all its moments from the first of its run on, of which others may have the beginning in common.

    `scales` are first steps and numbers of its scales; `steered` is whether it was changed between its steps.
    """

    identity: int
    name: str
    run: int
    path: list[Moment]
    scales: list[tuple[int, int]]
    steered: bool = False
    renamed: bool = False

    @property
    def first(self) -> int:
        return self.path[0].step

    @property
    def last(self) -> int:
        return self.path[-1].step

    def common(self, other: _Line) -> int:
        """How many moments it has in common with another branch."""
        most = range(min(len(self.path), len(other.path)))
        return bisect_left(most, True, key=lambda at: self.path[at] is not other.path[at])

    def scales_until(self, step: int) -> list[tuple[int, int]]:
        return [mark for mark in self.scales if mark[0] <= step]


class Timeline:
    """The steps of all runs and their branches, and the current one; states take at most `budget` bytes."""

    def __init__(self, apply: Apply, budget: int) -> None:
        self.edition = 0
        """Changes whenever something is recorded, renamed or removed."""
        self._apply = apply
        self._kept = KeptStates(budget)
        self._lines: dict[int, _Line] = {}
        self._line: _Line | None = None
        self._step = 0
        self._numbered, self._named = 0, [0, 0]
        self._outline: tuple[Branch, ...] | None = None
        self.fallen: tuple[str, ...] = ()
        """Names of the runs that were removed to make room."""

    # State

    @property
    def used(self) -> int:
        """Bytes that the states take."""
        return self._kept.used

    @property
    def kept(self) -> int:
        """Number of states that are kept."""
        return len(self._kept)

    @property
    def budget(self) -> int:
        """Maximum number of bytes of the states."""
        return self._kept.budget

    @budget.setter
    def budget(self, budget: int) -> None:
        self._kept.budget = budget
        self._make_room()

    @property
    def branches(self) -> tuple[Branch, ...]:
        """All branches, the oldest first; the same tuple until a branch comes, goes, is renamed or changes its scale.

        Meanwhile the current branch may be longer than its `last` says.
        """
        if self._outline is None:
            self._outline = tuple(map(self._branch, self._lines.values()))
        return self._outline

    @property
    def runs(self) -> tuple[int, ...]:
        """Numbers of the runs, the oldest first."""
        return tuple(dict.fromkeys(line.run for line in self._lines.values()))

    @property
    def here(self) -> BranchStep | None:
        """Current branch and step; None before a run has begun."""
        return None if self._line is None else (self._line.identity, self._step)

    @property
    def run(self) -> int:
        """Number of the current run, 0 before there is one."""
        return 0 if self._line is None else self._line.run

    @property
    def actions(self) -> tuple[RunAction, ...]:
        """The actions of the current step: the one that it was taken with, and later changes of its state."""
        return () if self._kept.here is None else self._kept.here.actions

    @property
    def steered(self) -> bool:
        """Whether there is more than one run that went on without a change to its end."""
        return len(self._lines) > 1 or any(line.steered for line in self._lines.values())

    @property
    def here_steered(self) -> bool:
        """Whether the current branch was changed between its steps."""
        return self._line is not None and self._line.steered

    def run_of(self, branch: int) -> int:
        """Number of the run that a branch belongs to."""
        return self._known(branch).run

    def state(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """The state of a step, as `go` gives it, without going there."""
        line = self._known(branch)
        return self._recover(_moment(line, step), wanted)

    def kept_state(self, branch: int, step: int) -> MethodState | None:
        """The state of a step if it need not be computed again."""
        return self._kept.get(_moment(self._known(branch), step))

    def own_actions(self, branch: int) -> tuple[tuple[RunAction, ...], ...]:
        """The actions of each step of a branch from that on which it leaves its parent, there only its own ones."""
        line = self._known(branch)
        parent, first = self._leaves(line)
        steps = [moment.actions for moment in line.path[first - line.first :]]
        if parent is not None:
            steps[0] = steps[0][len(_moment(parent, first).actions) :]
        return tuple(steps)

    # Recording

    def begin(self, state: MethodState) -> int:
        """Begin another run with its first state, and return its number; runs without a step are removed."""
        for run in self.runs:
            lines = [line for line in self._lines.values() if line.run == run]
            if len(lines) == 1 and not lines[0].renamed and [at.before for at in lines[0].path] == [None]:
                self._remove_run(run)
        run = self._numbered + 1
        line = self._open([Moment(run, state.step)], [(state.step, state.scale)], run, tr("Run {number}"))
        self.edition += 1
        self._arrive(line, state)
        return run

    def record(self, action: RunAction, state: MethodState) -> None:
        """Add the step after the current one.

        A new branch begins where the action differs from the recorded one; otherwise the run goes on along the branch.
        ValueError when the state is not that of the next step.
        """
        line, moment = self._here()
        if state.step != self._step + 1:
            raise ValueError(f"step {state.step} does not follow step {self._step}.")
        at = state.step - line.first
        following = ((other, other.path[at]) for other in (line, *self._lines.values()) if len(other.path) > at)
        for other, after in following:
            if after.before is moment and after.action == action:
                self._arrive(other, state)
                return
        if self._step < line.last:
            line = self._fork(line, line.path[:at])
        line.path.append(Moment(line.run, state.step, moment, action))
        line.steered = line.steered or action != line.path[1].action
        if state.scale != line.scales[-1][1]:
            line.scales.append((state.step, state.scale))
            self._outline = None
        self.edition += 1
        self._arrive(line, state)

    def amend(self, action: RunAction, state: MethodState, apart: bool = False) -> None:
        """Change the current state without a step.

        If other steps have followed from it, the change begins a new branch; so it does if it is to be kept `apart`,
        so that the state before it can be gone back to.
        """
        line, moment = self._here()
        at = self._step - line.first
        others = (other.path[at] for other in self._lines.values() if other is not line and len(other.path) > at)
        if apart or self._step < line.last or moment in others:
            line = self._fork(line, line.path[:at])
        else:
            line.path.pop()
            line.steered = True
            if moment.before is not None:
                self._kept.drop(moment)
        line.path.append(Moment(line.run, self._step, moment, action))
        self.edition += 1
        self._arrive(line, state)

    # Going

    def go(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """Go to a step, or to the nearest one of its branch, and return its state, exactly as it was.

        `wanted` is called between steps that have to be repeated; where it returns False, nothing changes and the
        result is None. ValueError when there is no such branch.
        """
        line = self._known(branch)
        state = self._recover(_moment(line, step), wanted)
        if state is not None:
            self._outline = None
            self._arrive(line, state)
        return state

    def restart(self, run: int) -> None:
        """Go to the first step of a run."""
        line = next(line for line in self._lines.values() if line.run == run)
        self.go(line.identity, line.first)

    def leave(self) -> None:
        """Leave the current run, which is kept; the next one begins elsewhere."""
        self._line, self._step, self._kept.here, self._outline = None, 0, None, None

    # Branches

    def rename(self, branch: int, name: str) -> None:
        """Give a branch another name; an empty one changes nothing."""
        line = self._known(branch)
        if name.strip():
            line.name, line.renamed = name.strip(), True
            self._change()

    def drop(self, branch: int) -> None:
        """Remove a branch; steps that others have in common with it stay with them.

        If the run is on a removed step, it goes back to where that branch began, or to the end of the run before.
        ValueError when there is no such branch, or no other one.
        """
        line = self._known(branch)
        if len(self._lines) == 1:
            raise ValueError(tr("The only run cannot be deleted."))
        was_here, step = self._line is line, self._step
        rest = [other for other in self._lines.values() if other.run == line.run and other is not line]
        if not rest:
            older = [other for other in self._lines.values() if other.identity < line.run]
            last = older or [other for other in self._lines.values() if other is not line]
            roots = [other for other in last if other is next(each for each in last if each.run == other.run)]
            self._remove_run(line.run)
            if was_here:
                self.go(roots[-1].identity, roots[-1].last)
            return
        if any(not other.common(rest[0]) and rest[0].path[0] not in _changed(other.path[0]) for other in rest):
            message = tr("{name} cannot be deleted: several branches begin with its step {step}.")
            raise ValueError(message.format(name=line.name, step=line.first))
        del self._lines[branch]
        self._change()
        if was_here:
            other = max(rest, key=line.common)
            self.go(other.identity, min(step, max(line.common(other) - 1, 0) + line.first))
        self._kept.keep_only(line.run, {moment for other in rest for moment in other.path})

    def clear(self) -> None:
        """Remove everything."""
        self.leave()
        self._lines, self._numbered, self._named, self.fallen = {}, 0, [0, 0], ()
        self._kept.clear()
        self.edition += 1

    def restore(
        self,
        branches: Sequence[StoredBranch],
        begun: Mapping[int, MethodState],
        states: Mapping[BranchStep, MethodState],
    ) -> None:
        """Remove everything and take over branches, with the first states of their runs and others that are known.

        Parents come before other branches, and the number of a run is that of its first branch.
        """
        self.clear()
        for branch in branches:
            self._adopt(branch, begun)
        for (number, step), state in states.items():
            self._kept.put(_moment(self._known(number), step), state)
        self._make_room()

    def _adopt(self, branch: StoredBranch, begun: Mapping[int, MethodState]) -> None:
        """Add a branch as it was."""
        parent = None if branch.parent is None else self._known(branch.parent)
        run = branch.number if parent is None else parent.run
        path: list[Moment] = [Moment(run, branch.first)]
        scales = list(branch.scales)
        if parent is not None:
            path, scales = parent.path[: branch.first - parent.first + 1], parent.scales_until(branch.first) + scales
        else:
            self._kept.put(path[0], begun[run])
        for step, actions in enumerate(branch.steps, branch.first):
            moment = path[-1] if step > branch.first else path.pop()
            for action in actions:
                moment = Moment(run, step, moment, action)
            path.append(moment)
        alike = all(moment.actions == path[1].actions for moment in path[1:])
        steered = parent is not None or bool(path[0].actions) or not alike
        self._lines[branch.number] = _Line(branch.number, branch.name, run, path, scales, steered, branch.renamed)
        self._numbered = max(self._numbered, branch.number)
        kind, number = parent is not None, branch.name.rpartition(" ")[2]
        self._named[kind] = max(self._named[kind] + 1, int(number) if number.isdecimal() else 0)

    # Internal

    def _known(self, branch: int) -> _Line:
        if branch not in self._lines:
            raise ValueError(tr("There is no branch {number} (any more).").format(number=branch))
        return self._lines[branch]

    def _here(self) -> tuple[_Line, Moment]:
        if self._line is None or self._kept.here is None:
            raise ValueError("the timeline has not begun.")
        return self._line, self._kept.here

    def _branch(self, line: _Line) -> Branch:
        """A branch as the window shows it."""
        parent, first = self._leaves(line)
        scales = tuple(mark for mark in line.scales if parent is None or mark[0] > first)
        leaves = None if parent is None else parent.identity
        return Branch(line.identity, line.name, leaves, first, line.last, scales, line.run, line.renamed)

    def _leaves(self, line: _Line) -> tuple[_Line | None, int]:
        """Of the older branches the one that most of a branch is in common with, None without one; and until when."""
        older = takewhile(lambda other: other is not line, self._lines.values())
        parent = max((other for other in older if other.run == line.run), key=line.common, default=None)
        if parent is None:
            return None, line.first
        at = line.common(parent)
        both = at < min(len(line.path), len(parent.path))
        changed = both and parent.path[at] in _changed(line.path[at])
        return parent, line.path[at if changed else at - 1].step

    def _open(self, path: list[Moment], scales: list[tuple[int, int]], run: int, name: str) -> _Line:
        """Add a branch; a run has the number of its first one."""
        self._numbered += 1
        branches = run != self._numbered
        self._named[branches] += 1
        name = name.format(number=self._named[branches])
        line = self._lines[self._numbered] = _Line(self._numbered, name, run, path, scales, steered=branches)
        self._outline = None
        return line

    def _fork(self, line: _Line, path: list[Moment]) -> _Line:
        return self._open(path, line.scales_until(self._step), line.run, tr("Branch {number}"))

    def _arrive(self, line: _Line, state: MethodState) -> None:
        """Be at the step of a branch that has this state."""
        if line is not self._line:
            self._outline = None
        moment = _moment(line, state.step)
        self._line, self._step, self._kept.here = line, state.step, moment
        self._kept.put(moment, state)
        self._make_room()

    def _recover(self, moment: Moment, wanted: Callable[[], bool]) -> MethodState | None:
        missing = []
        while (state := self._kept.get(moment)) is None:
            missing.append(moment)
            assert moment.before is not None
            moment = moment.before
        for moment in reversed(missing):
            if not wanted():
                return None
            assert moment.action is not None
            state = self._apply(moment.run, state, moment.action)
            self._kept.put(moment, state)
        return state

    def _change(self) -> None:
        """The branches are others than before."""
        self.edition += 1
        self._outline = None

    def _remove_run(self, run: int) -> None:
        if self.run == run:
            self.leave()
        self._lines = {branch: line for branch, line in self._lines.items() if line.run != run}
        self._kept.keep_only(run, set())
        self._change()

    def _make_room(self) -> None:
        """Remove the oldest runs, those that have been named last, until the others have room; never the newest one."""
        self._kept.make_room()
        while self.used > self.budget or len(self.runs) > MOST_RUNS:
            roots = [next(line for line in self._lines.values() if line.run == run) for run in self.runs[:-1]]
            oldest = min((one for one in roots if one.run != self.run), key=lambda one: one.renamed, default=None)
            if oldest is None:
                return
            self.fallen = (*self.fallen, oldest.name)
            self._remove_run(oldest.run)


def _moment(line: _Line, step: int) -> Moment:
    """The moment of a step of a branch, or of its nearest one."""
    return line.path[min(max(step - line.first, 0), len(line.path) - 1)]


def _changed(moment: Moment) -> list[Moment]:
    """The moments of the same step that a moment has been made of."""
    found = []
    while moment.before is not None and moment.before.step == moment.step:
        moment = moment.before
        found.append(moment)
    return found
