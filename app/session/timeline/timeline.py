"""The timeline of a run: every step can be had again, and from any of them the run can go on otherwise.

A step follows from the state before it and from what it was taken with, its deed, and from nothing else. So deeds are
kept of all steps and states only of some, as far as the memory reaches; any other state is worked out anew from the
nearest one before it, bit for bit the same. Nothing here knows of threads or of the window.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic

from app.model.text.language import tr
from app.session.timeline.branches import Branch, Deed, Line, Lineage
from app.session.timeline.state_cache import KeptStates, Place
from cpm_core.parameters import Parameters
from cpm_core.particles.state import State


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
    parameters : Parameters or None
        With which the step that the run stands at was taken; None for the first.
    """

    branches: tuple[Branch, ...] = ()
    branch: int = 0
    used: int = 0
    budget: int = 0
    kept: int = 0
    parameters: Parameters | None = None


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
        self._lines: Lineage[Deed] = Lineage()
        self._line: Line[Deed] | None = None
        self._step = 0

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

        In between, the branch where the run stands may have gone further than its `last` says.
        """
        return self._lines.outline

    @property
    def here(self) -> tuple[int, int] | None:
        """Branch and step where the run stands; None before it has begun."""
        return None if self._line is None else (self._line.identity, self._step)

    @property
    def deeds(self) -> tuple[Deed, ...]:
        """What the step where the run stands was taken by, and what its state has been changed by since."""
        if self._line is None:
            return ()
        owner = self._lines.owner(self._line, self._step)
        return owner.deeds[self._step - owner.first]

    def reach(self, branch: int) -> int:
        """The last step of a branch.

        Raises
        ------
        ValueError
            When there is no such branch.
        """
        return self._lines.known(branch).last

    def follows(self, deed: Deed) -> bool:
        """Whether taking this step from here would only repeat what is recorded."""
        return self._lines.repeated(self._here(), self._step, deed) is not None

    # Recording

    def clear(self) -> None:
        """Forget everything."""
        self._lines.clear()
        self._kept.clear()
        self._line, self._step = None, 0

    def begin(self, state: State) -> None:
        """Forget everything and begin with the first state of a run."""
        self.clear()
        line = self._lines.open(None, state.step, ())
        self._lines.mark(line, state.step, state.scale)
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
        repeated = self._lines.repeated(line, self._step, deed)
        if repeated is not None:
            line = repeated
        else:
            if self._step < line.last:
                line = self._lines.open(self._lines.owner(line, self._step), self._step, ())
            line.deeds.append((deed,))
            self._lines.mark(line, state.step, state.scale)
        self._stand(line, state.step)
        self._kept.put((line.identity, state.step), state)

    def amend(self, deed: Deed, state: State) -> None:
        """Change the state where the run stands, without a step.

        What other steps have followed from stays as it is: the change then begins a new branch.
        """
        line, step = self._here(), self._step
        if step < line.last or self._lines.forks(line, step):
            line = self._lines.open(self._lines.owner(line, step), step, (deed,))
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
        line = self._lines.known(branch)
        step = min(max(step, self._lines.root.first), line.last)
        state = self._recover(line, step, wanted)
        if state is not None:
            self._lines.touch()
            self._stand(line, step)
            self._kept.put(self._place(line, step), state)
        return state

    def state(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> State | None:
        """Give the state of another step as `go` does, without going there."""
        line = self._lines.known(branch)
        return self._recover(line, min(max(step, self._lines.root.first), line.last), wanted)

    def rename(self, branch: int, name: str) -> None:
        """Give a branch another name; an empty one changes nothing."""
        line = self._lines.known(branch)
        if name.strip():
            line.name = name.strip()
            self._lines.touch()

    def drop(self, branch: int) -> None:
        """Forget a branch; what others have in common with it stays with them.

        The one of them that leaves it last takes its beginning over. Where the run stands on what is forgotten it goes
        back to where that began.

        Raises
        ------
        ValueError
            When there is no such branch, or no other one.
        """
        line = self._lines.known(branch)
        if len(self._lines) == 1:
            raise ValueError(tr("The only branch cannot be deleted: reset the run instead."))
        heir = self._lines.heir(line)
        if heir is not None:
            self._inherit(line, heir)
        else:
            parent = self._lines.parent(line)
            self._kept.hand_over(line.identity, parent.identity, line.first - 1)
            if self._line is line:
                self._return_to(self._lines.owner(parent, line.first), line.first)
        self._lines.remove(line)

    # Inside

    def _here(self) -> Line[Deed]:
        if self._line is None:
            raise ValueError("the timeline has not begun.")
        return self._line

    def _stand(self, line: Line[Deed], step: int) -> None:
        if line is not self._line:
            self._lines.touch()
        self._line, self._step = line, step
        self._kept.fix("here", self._place(line, step))

    def _place(self, line: Line[Deed], step: int) -> Place:
        return (self._lines.owner(line, step).identity, step)

    def _recover(self, line: Line[Deed], step: int, wanted: Callable[[], bool]) -> State | None:
        owner = self._lines.owner(line, step)
        missing: list[tuple[Line[Deed], int]] = []
        while (nearest := self._kept.get((owner.identity, step))) is None:
            missing.append((owner, step))
            if step > owner.first:
                owner = self._lines.owner(owner, step - 1)
                step -= 1
            else:
                owner = self._lines.owner(self._lines.parent(owner), step)
        state = nearest
        for its, at in reversed(missing):
            if not wanted():
                return None
            for deed in its.deeds[at - its.first]:
                state = self._again(state, deed)
            self._kept.put((its.identity, at), state)
        return state

    def _inherit(self, line: Line[Deed], heir: Line[Deed]) -> None:
        """Let a branch that leaves another one take its beginning over."""
        fork, step = heir.first, self._step
        forking = self._recover(heir, fork, lambda: True)
        assert forking is not None
        self._lines.bequeath(line, heir)
        self._kept.hand_over(line.identity, heir.identity, fork - 1)
        self._kept.put((heir.identity, fork), forking)
        if self._line is line:
            self._return_to(heir, min(step, fork))

    def _return_to(self, line: Line[Deed], step: int) -> None:
        state = self._recover(line, step, lambda: True)
        assert state is not None
        self._stand(line, step)
        self._kept.put(self._place(line, step), state)
