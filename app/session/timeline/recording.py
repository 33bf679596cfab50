"""Recording of steps, of branches and of runs."""

from __future__ import annotations

from app.session.timeline.branches import BranchNode, RunAction
from app.session.timeline.recorded_steps import Apply, RecordedSteps
from cpm_core.segmentation.method import MethodState

MOST_RUNS = 12
"""Largest number of runs that are kept."""


class Recording(RecordedSteps[RunAction]):
    """Records steps, and keeps as many runs as there is room for."""

    def __init__(self, apply: Apply[RunAction], budget: int) -> None:
        super().__init__(apply, budget)
        self._node: BranchNode[RunAction] | None = None
        self._step = 0
        self.fallen: tuple[str, ...] = ()
        """Names of the runs that were removed to make room."""

    @property
    def here(self) -> tuple[int, int] | None:
        """Current branch and step; None before a run has begun."""
        return None if self._node is None else (self._node.identity, self._step)

    @property
    def run(self) -> int:
        """Number of the current run, 0 before there is one."""
        return 0 if self._node is None else self._node.run

    @property
    def actions(self) -> tuple[RunAction, ...]:
        """The actions of the current step: the one that it was taken with, and later changes of its state."""
        if self._node is None:
            return ()
        owner = self._tree.owner(self._node, self._step)
        return owner.actions[self._step - owner.first]

    @property
    def budget(self) -> int:
        """Maximum number of bytes of the states."""
        return self._kept.budget

    @budget.setter
    def budget(self, budget: int) -> None:
        self._kept.budget = budget
        self._make_room()

    def clear(self) -> None:
        """Remove everything."""
        self._tree.clear()
        self._kept.clear()
        self._node, self._step = None, 0
        self.fallen = ()
        self.edition += 1

    def leave(self) -> None:
        """Leave the current run, which is kept; the next one begins elsewhere."""
        self._node, self._step = None, 0
        self._kept.release("here")
        self._tree.touch()

    def begin(self, state: MethodState) -> int:
        """Begin another run with its first state, and return its number; runs without a step are removed."""
        for root in self._tree.roots:
            if root.empty and not root.renamed and len(self._tree.of_run(root.run)) == 1:
                self._remove_run(root.run)
        node = self._tree.open(None, state.step, ())
        self._tree.mark(node, state.step, state.scale)
        self._set_place(node, state.step)
        self._kept.fix(f"first of {node.run}", (node.identity, state.step))
        self._kept.put((node.identity, state.step), state)
        self.edition += 1
        self._make_room()
        return node.run

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
            node.add(action)
            self._tree.mark(node, state.step, state.scale)
            self.edition += 1
        self._set_place(node, state.step)
        self._kept.put((node.identity, state.step), state)
        self._make_room()

    def amend(self, action: RunAction, state: MethodState, apart: bool = False) -> None:
        """Change the current state without a step.

        If other steps have followed from it, the change begins a new branch; so it does if it is to be kept `apart`,
        so that the state before it can be gone back to.
        """
        node, step = self._here(), self._step
        if apart or step < node.last or self._tree.forks(node, step):
            node = self._tree.open(self._tree.owner(node, step), step, (action,))
        else:
            node.amend(action)
        self.edition += 1
        self._set_place(node, step)
        self._kept.put(self._place(node, step), state)
        self._make_room()

    def _here(self) -> BranchNode[RunAction]:
        if self._node is None:
            raise ValueError("the timeline has not begun.")
        return self._node

    def _set_place(self, node: BranchNode[RunAction], step: int) -> None:
        if node is not self._node:
            self._tree.touch()
        self._node, self._step = node, step
        self._kept.fix("here", self._place(node, step))

    def _remove_run(self, run: int) -> None:
        self._kept.release(f"first of {run}")
        for node in self._tree.of_run(run):
            self._kept.drop_branch(node.identity)
            self._tree.remove(node)
        self._change()

    def _make_room(self) -> None:
        """Remove the oldest runs, those that have been named last, until the others have room; never the newest one."""
        while self._kept.used > self._kept.budget or len(self._tree.roots) > MOST_RUNS:
            others = [root for root in self._tree.roots[:-1] if root.run != self.run]
            if not others:
                return
            oldest = min(others, key=lambda root: (root.renamed, root.identity))
            self.fallen = (*self.fallen, oldest.name)
            self._remove_run(oldest.run)
