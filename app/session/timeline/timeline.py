"""The timeline of a run: every step can be recovered, and the run can continue from any of them.

A step depends only on the state before it and on its action. So the actions of all steps are kept, and as many states
as memory allows; any other state is computed again from the nearest one before it, bit for bit the same. Threads and
the window are not known here.
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
    """

    branches: tuple[Branch, ...] = ()
    branch: int = 0
    used: int = 0
    budget: int = 0
    kept: int = 0
    parameters: Parameters | None = None


class RecordedSteps(Generic[RunAction]):
    """The steps of a run and its branches, any of which can be recovered.

    `apply` gives the next state from a state and an action, always the same one. States take at most `budget` bytes,
    but the first and the current one are always kept.
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
        """Maximum number of bytes of the states."""
        return self._kept.budget

    @budget.setter
    def budget(self, budget: int) -> None:
        self._kept.budget = budget

    @property
    def branches(self) -> tuple[Branch, ...]:
        """All branches, the oldest first; the same tuple until a branch comes, goes, is renamed or changes its scale.

        Meanwhile the current branch may be longer than its `last` says.
        """
        return self._tree.outline

    def state(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """The state of a step, as `go` gives it, without going there."""
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
    """The steps of a run and its branches, and the current one."""

    def __init__(self, apply: Callable[[MethodState, RunAction], MethodState], budget: int) -> None:
        super().__init__(apply, budget)
        self._node: BranchNode[RunAction] | None = None
        self._step = 0

    @property
    def here(self) -> tuple[int, int] | None:
        """Current branch and step; None before the run has begun."""
        return None if self._node is None else (self._node.identity, self._step)

    @property
    def actions(self) -> tuple[RunAction, ...]:
        """The actions of the current step: the one that it was taken with, and later changes of its state."""
        if self._node is None:
            return ()
        owner = self._tree.owner(self._node, self._step)
        return owner.actions[self._step - owner.first]

    # Recording

    def clear(self) -> None:
        """Remove everything."""
        self._tree.clear()
        self._kept.clear()
        self._node, self._step = None, 0

    def begin(self, state: MethodState) -> None:
        """Remove everything and begin with the first state of a run."""
        self.clear()
        node = self._tree.open(None, state.step, ())
        self._tree.mark(node, state.step, state.scale)
        self._set_place(node, state.step)
        self._kept.fix("first", (node.identity, state.step))
        self._kept.put((node.identity, state.step), state)

    def record(self, action: RunAction, state: MethodState) -> None:
        """Add the step after the current one.

        A new branch begins where the action differs from the recorded one; otherwise the run goes on along the branch.
        ValueError when the state is not that of the next step.
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
        self._set_place(node, state.step)
        self._kept.put((node.identity, state.step), state)

    def amend(self, action: RunAction, state: MethodState) -> None:
        """Change the current state without a step.

        If other steps have followed from it, the change begins a new branch.
        """
        node, step = self._here(), self._step
        if step < node.last or self._tree.forks(node, step):
            node = self._tree.open(self._tree.owner(node, step), step, (action,))
        else:
            node.actions[-1] = (*node.actions[-1], action)
        self._set_place(node, step)
        self._kept.put(self._place(node, step), state)

    # Going

    def go(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """Go to a step, or to the nearest one of its branch, and return its state, exactly as it was.

        `wanted` is called between steps that have to be repeated; where it returns False, nothing changes and the
        result is None. ValueError when there is no such branch.
        """
        node = self._tree.known(branch)
        step = min(max(step, self._tree.root.first), node.last)
        state = self._recover(node, step, wanted)
        if state is not None:
            self._tree.touch()
            self._set_place(node, step)
            self._kept.put(self._place(node, step), state)
        return state

    def drop(self, branch: int) -> None:
        """Remove a branch; steps that others have in common with it stay with them.

        The branch that leaves it last takes over its beginning. If the run is on a removed step, it goes back to where
        that branch began. ValueError when there is no such branch, or no other one.
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

    def _here(self) -> BranchNode[RunAction]:
        if self._node is None:
            raise ValueError("the timeline has not begun.")
        return self._node

    def _set_place(self, node: BranchNode[RunAction], step: int) -> None:
        if node is not self._node:
            self._tree.touch()
        self._node, self._step = node, step
        self._kept.fix("here", self._place(node, step))

    def _inherit(self, node: BranchNode[RunAction], descendant: BranchNode[RunAction]) -> None:
        """Give the beginning of a branch to its descendant."""
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
        self._set_place(node, step)
        self._kept.put(self._place(node, step), state)
