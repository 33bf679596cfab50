"""The timeline of a run: every step can be had again, and from any of them the run can go on otherwise.

A step follows from the state before it and from its action, and from nothing else. So actions are kept of all steps and
states only of some, as far as memory reaches; any other state is worked out anew from the nearest one before it, bit
for bit the same. Nothing here knows of threads or of the window.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic

from app.model.text.language import tr
from app.session.timeline.branches import Branch, BranchNode, Lineage, RunAction
from app.session.timeline.state_cache import KeptStates, Place
from cpm_core.parameters import Parameters
from cpm_core.segmentation.method import MethodState


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


class RecordedSteps(Generic[RunAction]):
    """The steps of a run and its branches, any of which can be had again.

    Parameters
    ----------
    apply : callable
        State and action to the next state, always the same one.
    budget : int
        Most bytes that states may take; the first of the run and the one where it stands are kept in any case.
    """

    def __init__(self, apply: Callable[[MethodState, RunAction], MethodState], budget: int) -> None:
        self._apply = apply
        self._kept = KeptStates(budget)
        self._tree: Lineage[RunAction] = Lineage()

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
        return self._tree.outline

    def state(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """Give the state of another step as `go` does, without going there."""
        node = self._tree.known(branch)
        return self._recover(node, min(max(step, self._tree.root.first), node.last), wanted)

    def rename(self, branch: int, name: str) -> None:
        """Give a branch another name; an empty one changes nothing."""
        node = self._tree.known(branch)
        if name.strip():
            node.name = name.strip()
            self._tree.touch()

    def _place(self, node: BranchNode[RunAction], step: int) -> Place:
        return (self._tree.owner(node, step).identity, step)

    def _recover(self, node: BranchNode[RunAction], step: int, wanted: Callable[[], bool]) -> MethodState | None:
        owner = self._tree.owner(node, step)
        missing: list[tuple[BranchNode[RunAction], int]] = []
        while (nearest := self._kept.get((owner.identity, step))) is None:
            missing.append((owner, step))
            if step > owner.first:
                owner = self._tree.owner(owner, step - 1)
                step -= 1
            else:
                owner = self._tree.owner(self._tree.parent(owner), step)
        state = nearest
        for its, at in reversed(missing):
            if not wanted():
                return None
            for action in its.actions[at - its.first]:
                state = self._apply(state, action)
            self._kept.put((its.identity, at), state)
        return state


class Timeline(RecordedSteps[RunAction]):
    """The steps of a run and its branches, and the place among them where the run stands."""

    def __init__(self, apply: Callable[[MethodState, RunAction], MethodState], budget: int) -> None:
        super().__init__(apply, budget)
        self._node: BranchNode[RunAction] | None = None
        self._step = 0

    @property
    def here(self) -> tuple[int, int] | None:
        """Branch and step where the run stands; None before it has begun."""
        return None if self._node is None else (self._node.identity, self._step)

    @property
    def actions(self) -> tuple[RunAction, ...]:
        """What the step where the run stands was taken by, and what its state has been changed by since."""
        if self._node is None:
            return ()
        owner = self._tree.owner(self._node, self._step)
        return owner.actions[self._step - owner.first]

    # Recording

    def clear(self) -> None:
        """Forget everything."""
        self._tree.clear()
        self._kept.clear()
        self._node, self._step = None, 0

    def begin(self, state: MethodState) -> None:
        """Forget everything and begin with the first state of a run."""
        self.clear()
        node = self._tree.open(None, state.step, ())
        self._tree.mark(node, state.step, state.scale)
        self._stand(node, state.step)
        self._kept.fix("first", (node.identity, state.step))
        self._kept.put((node.identity, state.step), state)

    def record(self, action: RunAction, state: MethodState) -> None:
        """Add the step that an action has led to from where the run stands.

        Where it differs from what was recorded a new branch begins; where it does not the run goes on along the branch.

        Raises
        ------
        ValueError
            When the state is not that of the next step.
        """
        node = self._here()
        if state.step != self._step + 1:
            raise ValueError(f"step {state.step} does not follow step {self._step}.")
        repeated = self._tree.repeated(node, self._step, action)
        if repeated is not None:
            node = repeated
        else:
            if self._step < node.last:
                node = self._tree.open(self._tree.owner(node, self._step), self._step, ())
            node.actions.append((action,))
            self._tree.mark(node, state.step, state.scale)
        self._stand(node, state.step)
        self._kept.put((node.identity, state.step), state)

    def amend(self, action: RunAction, state: MethodState) -> None:
        """Change the state where the run stands, without a step.

        What other steps have followed from stays as it is: the change then begins a new branch.
        """
        node, step = self._here(), self._step
        if step < node.last or self._tree.forks(node, step):
            node = self._tree.open(self._tree.owner(node, step), step, (action,))
        else:
            node.actions[-1] = (*node.actions[-1], action)
        self._stand(node, step)
        self._kept.put(self._place(node, step), state)

    # Going

    def go(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """Stand at another step, as near to it as the branch has one.

        Parameters
        ----------
        branch, step : int
            Where to.
        wanted : callable
            Asked between steps that have to be taken anew; where it says no, nothing changes.

        Returns
        -------
        MethodState or None
            The state of that step, exactly as it was; None when it was no longer wanted.

        Raises
        ------
        ValueError
            When there is no such branch.
        """
        node = self._tree.known(branch)
        step = min(max(step, self._tree.root.first), node.last)
        state = self._recover(node, step, wanted)
        if state is not None:
            self._tree.touch()
            self._stand(node, step)
            self._kept.put(self._place(node, step), state)
        return state

    def drop(self, branch: int) -> None:
        """Forget a branch; what others have in common with it stays with them.

        The one of them that leaves it last takes its beginning over. Where the run stands on what is forgotten it goes
        back to where that began.

        Raises
        ------
        ValueError
            When there is no such branch, or no other one.
        """
        node = self._tree.known(branch)
        if len(self._tree) == 1:
            raise ValueError(tr("The only branch cannot be deleted: reset the run instead."))
        descendant = self._tree.descendant(node)
        if descendant is not None:
            self._inherit(node, descendant)
        else:
            parent = self._tree.parent(node)
            self._kept.hand_over(node.identity, parent.identity, node.first - 1)
            if self._node is node:
                self._return_to(self._tree.owner(parent, node.first), node.first)
        self._tree.remove(node)

    # Inside

    def _here(self) -> BranchNode[RunAction]:
        if self._node is None:
            raise ValueError("the timeline has not begun.")
        return self._node

    def _stand(self, node: BranchNode[RunAction], step: int) -> None:
        if node is not self._node:
            self._tree.touch()
        self._node, self._step = node, step
        self._kept.fix("here", self._place(node, step))

    def _inherit(self, node: BranchNode[RunAction], descendant: BranchNode[RunAction]) -> None:
        """Let a branch that leaves another one take its beginning over."""
        fork, step = descendant.first, self._step
        forking = self._recover(descendant, fork, lambda: True)
        assert forking is not None
        self._tree.hand_over(node, descendant)
        self._kept.hand_over(node.identity, descendant.identity, fork - 1)
        self._kept.put((descendant.identity, fork), forking)
        if self._node is node:
            self._return_to(descendant, min(step, fork))

    def _return_to(self, node: BranchNode[RunAction], step: int) -> None:
        state = self._recover(node, step, lambda: True)
        assert state is not None
        self._stand(node, step)
        self._kept.put(self._place(node, step), state)
