"""The timeline of a run: every step can be had again, and from any of them the run can go on otherwise.

A step follows from the state before it and from what it was taken with, its deed, and from nothing else. So deeds are
kept of all steps and states only of some, as far as the memory reaches; any other state is worked out anew from the
nearest one before it, bit for bit the same. Nothing here knows of threads or of the window.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from app.model.language import tr
from app.session.kept_states import KeptStates, Place
from cpm_core.particles import State

Deed = TypeVar("Deed")
"""What leads from one state to the next; deeds that are equal lead from the same state to the same one."""


@dataclass(frozen=True, slots=True)
class Branch:
    """One way that a run has gone, as it is told of.

    Attributes
    ----------
    identity : int
        Its number, never given twice in a run.
    name : str
        Name for people.
    parent : int or None
        The branch that it leaves; None for the one that begins with the run.
    first, last : int
        Step at which it leaves its parent, and the last one recorded.
    scales : tuple of tuple of int
        Steps with which a scale begins, and that scale; only of its own steps.
    """

    identity: int
    name: str
    parent: int | None
    first: int
    last: int
    scales: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class Outline:
    """How the timeline stands, as the window shows it.

    Attributes
    ----------
    branches : tuple of Branch
        The oldest first; the same tuple as long as nothing but the last step of `branch` has changed.
    branch : int
        The branch that the run is on, 0 before there is one.
    used, budget : int
        Bytes that its states take, and may take.
    kept : int
        States that are kept; the others are worked out anew.
    """

    branches: tuple[Branch, ...] = ()
    branch: int = 0
    used: int = 0
    budget: int = 0
    kept: int = 0


@dataclass(eq=False, slots=True)
class _Line(Generic[Deed]):
    """What is recorded of a branch: the deeds of its steps from the first on.

    Each step has the deed that it was taken with and those by which its state was changed afterwards; of the first
    step, whose state is the parent's, only the latter.
    """

    identity: int
    name: str
    parent: int | None
    first: int
    deeds: list[tuple[Deed, ...]]
    scales: list[tuple[int, int]]

    @property
    def last(self) -> int:
        return self.first + len(self.deeds) - 1

    def outline(self) -> Branch:
        return Branch(self.identity, self.name, self.parent, self.first, self.last, tuple(self.scales))


class Timeline(Generic[Deed]):
    """The steps of a run and its branches, and the place among them where the run stands.

    Parameters
    ----------
    again : callable
        State and deed to the next state, always the same one.
    budget : int
        Most bytes that states may take; the first of the run and the one where it stands are kept in any case.
    """

    def __init__(self, again: Callable[[State, Deed], State], budget: int) -> None:
        self._again = again
        self._kept = KeptStates(budget)
        self._lines: dict[int, _Line[Deed]] = {}
        self._numbered = 0
        self._line: _Line[Deed] | None = None
        self._step = 0
        self._outline: tuple[Branch, ...] | None = ()

    # Looking

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
        """Most bytes that states may take."""
        return self._kept.budget

    @budget.setter
    def budget(self, budget: int) -> None:
        self._kept.budget = budget

    @property
    def branches(self) -> tuple[Branch, ...]:
        """All branches, the oldest first; the same tuple until a branch comes, goes, is renamed or changes its scale.

        In between the branch where the run stands may have gone further than its `last` says.
        """
        if self._outline is None:
            self._outline = tuple(line.outline() for line in self._lines.values())
        return self._outline

    @property
    def here(self) -> tuple[int, int] | None:
        """Branch and step where the run stands; None before it has begun."""
        return None if self._line is None else (self._line.identity, self._step)

    def reach(self, branch: int) -> int:
        """The last step of a branch.

        Raises
        ------
        ValueError
            When there is no such branch.
        """
        return self._known(branch).last

    def follows(self, deed: Deed) -> bool:
        """Whether taking this step from here would only repeat what is recorded."""
        return self._repeated(deed) is not None

    # Recording

    def clear(self) -> None:
        """Forget everything."""
        self._lines.clear()
        self._kept.clear()
        self._line, self._step, self._outline = None, 0, ()

    def begin(self, state: State) -> None:
        """Forget everything and begin with the first state of a run."""
        self.clear()
        self._numbered = 0
        line = self._open(None, state.step, ())
        line.scales.append((state.step, state.scale))
        self._stand(line, state.step)
        self._kept.fix("first", (line.identity, state.step))
        self._kept.put((line.identity, state.step), state)

    def record(self, deed: Deed, state: State) -> None:
        """Add the step that a deed has led to from where the run stands.

        Where it differs from what was recorded a new branch begins; where it does not the run goes on along the branch.

        Raises
        ------
        ValueError
            When the state is not that of the next step.
        """
        line = self._here()
        if state.step != self._step + 1:
            raise ValueError(f"step {state.step} does not follow step {self._step}.")
        repeated = self._repeated(deed) if self._step < line.last or len(self._lines) > 1 else None
        if repeated is not None:
            line = repeated
        else:
            if self._step < line.last:
                line = self._open(self._owner(line, self._step), self._step, ())
            line.deeds.append((deed,))
            if state.scale != self._scale(line, self._step):
                line.scales.append((state.step, state.scale))
                self._outline = None
        self._stand(line, state.step)
        self._kept.put((line.identity, state.step), state)

    def amend(self, deed: Deed, state: State) -> None:
        """Change the state where the run stands, without a step.

        What other steps have followed from stays as it is: the change then begins a new branch.
        """
        line, step = self._here(), self._step
        forked = any(other.parent == line.identity and other.first == step for other in self._lines.values())
        if step < line.last or forked:
            line = self._open(self._owner(line, step), step, (deed,))
        else:
            line.deeds[-1] = (*line.deeds[-1], deed)
        self._stand(line, step)
        self._kept.put(self._place(line, step), state)

    # Going

    def go(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> State | None:
        """Stand at another step, as near to it as the branch has one.

        Parameters
        ----------
        branch, step : int
            Where to.
        wanted : callable
            Asked between steps that have to be taken anew; where it says no, nothing changes.

        Returns
        -------
        State or None
            The state of that step, exactly as it was; None when it was no longer wanted.

        Raises
        ------
        ValueError
            When there is no such branch.
        """
        line = self._known(branch)
        step = min(max(step, self._root().first), line.last)
        state = self._recover(line, step, wanted)
        if state is not None:
            self._stand(line, step)
            self._kept.put(self._place(line, step), state)
        return state

    def state(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> State | None:
        """Give the state of another step as `go` does, without going there."""
        line = self._known(branch)
        return self._recover(line, min(max(step, self._root().first), line.last), wanted)

    def rename(self, branch: int, name: str) -> None:
        """Give a branch another name; an empty one changes nothing."""
        line = self._known(branch)
        if name.strip():
            line.name = name.strip()
            self._outline = None

    def drop(self, branch: int) -> None:
        """Forget a branch; what others have in common with it stays with them.

        The one of them that leaves it last takes its beginning over. Where the run stands on what is forgotten it goes
        back to where that began.

        Raises
        ------
        ValueError
            When there is no such branch, or no other one.
        """
        line = self._known(branch)
        if len(self._lines) == 1:
            raise ValueError(tr("The only branch cannot be deleted: reset the run instead."))
        heir = self._heir(line)
        if heir is not None:
            self._bequeath(line, heir)
        else:
            assert line.parent is not None
            self._kept.hand_over(line.identity, line.parent, line.first - 1)
            if self._line is line:
                parent = self._owner(self._lines[line.parent], line.first)
                state = self._recover(parent, line.first, lambda: True)
                assert state is not None
                self._stand(parent, line.first)
                self._kept.put((parent.identity, line.first), state)
        del self._lines[line.identity]
        self._outline = None

    # Inside

    def _here(self) -> _Line[Deed]:
        if self._line is None:
            raise ValueError("the timeline has not begun.")
        return self._line

    def _known(self, branch: int) -> _Line[Deed]:
        if branch not in self._lines:
            raise ValueError(tr("There is no branch {number} (any more).").format(number=branch))
        return self._lines[branch]

    def _root(self) -> _Line[Deed]:
        return next(line for line in self._lines.values() if line.parent is None)

    def _open(self, parent: _Line[Deed] | None, first: int, changes: tuple[Deed, ...]) -> _Line[Deed]:
        self._numbered += 1
        name = tr("Branch {number}").format(number=self._numbered)
        line = _Line(self._numbered, name, None if parent is None else parent.identity, first, [changes], [])
        self._lines[line.identity] = line
        self._outline = None
        return line

    def _scale(self, line: _Line[Deed], step: int) -> int:
        """Scale that a branch is at with a step."""
        for begun, scale in reversed(line.scales):
            if begun <= step:
                return scale
        assert line.parent is not None
        return self._scale(self._lines[line.parent], min(step, line.first))

    def _stand(self, line: _Line[Deed], step: int) -> None:
        if line is not self._line:
            self._outline = None
        self._line, self._step = line, step
        self._kept.fix("here", self._place(line, step))

    def _owner(self, line: _Line[Deed], step: int) -> _Line[Deed]:
        """The branch that a step of a branch is recorded in: itself, or one that it comes from."""
        while line.parent is not None and (step < line.first or (step == line.first and not line.deeds[0])):
            line = self._lines[line.parent]
        return line

    def _place(self, line: _Line[Deed], step: int) -> Place:
        return (self._owner(line, step).identity, step)

    def _repeated(self, deed: Deed) -> _Line[Deed] | None:
        """The branch, the one where the run stands before others, that has already gone on from here by this deed."""
        here, step = self._here(), self._step
        owner = self._owner(here, step)
        for line in (here, *self._lines.values()):
            own = line.first <= step < line.last
            if own and line.deeds[step + 1 - line.first] == (deed,) and self._owner(line, step) is owner:
                return line
        return None

    def _recover(self, line: _Line[Deed], step: int, wanted: Callable[[], bool]) -> State | None:
        owner = self._owner(line, step)
        missing: list[tuple[_Line[Deed], int]] = []
        while (nearest := self._kept.get((owner.identity, step))) is None:
            missing.append((owner, step))
            if step > owner.first:
                owner = self._owner(owner, step - 1)
                step -= 1
            else:
                assert owner.parent is not None
                owner = self._owner(self._lines[owner.parent], step)
        state = nearest
        for its, at in reversed(missing):
            if not wanted():
                return None
            for deed in its.deeds[at - its.first]:
                state = self._again(state, deed)
            self._kept.put((its.identity, at), state)
        return state

    def _heir(self, line: _Line[Deed]) -> _Line[Deed] | None:
        """Who takes the beginning of a branch over: of those that leave it last, one that changed nothing there."""
        children = [other for other in self._lines.values() if other.parent == line.identity]
        return max(children, key=lambda child: (child.first, not child.deeds[0]), default=None)

    def _bequeath(self, line: _Line[Deed], heir: _Line[Deed]) -> None:
        """Give the beginning of a branch to one that leaves it."""
        fork = heir.first
        others = [other for other in self._lines.values() if other.parent == line.identity and other is not heir]
        if heir.deeds[0] and any(other.first == fork for other in others):
            raise ValueError(
                tr("{name} cannot be deleted: several branches begin with its step {step}.").format(
                    name=line.name, step=fork
                )
            )
        forking = self._recover(heir, fork, lambda: True)
        assert forking is not None
        common = line.deeds[: fork - line.first + 1]
        heir.deeds = [*common[:-1], (*common[-1], *heir.deeds[0]), *heir.deeds[1:]]
        heir.first, heir.parent = line.first, line.parent
        heir.scales = [mark for mark in line.scales if mark[0] <= fork] + heir.scales
        for other in others:
            other.parent = heir.identity
        self._kept.hand_over(line.identity, heir.identity, fork - 1)
        self._kept.put((heir.identity, fork), forking)
        if self._line is line:
            step = min(self._step, fork)
            state = self._recover(heir, step, lambda: True)
            assert state is not None
            self._stand(heir, step)
            self._kept.put(self._place(heir, step), state)
