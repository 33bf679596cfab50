"""The recorded steps of all runs, any of which can be recovered.

A step depends only on the state before it and on its action. So the actions of all steps are kept, and as many states
as memory allows; any other state is computed again from the nearest one before it, bit for bit the same. Threads and
the window are not known here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic

from app.session.timeline.branches import Branch, BranchNode, Lineage, RunAction
from app.session.timeline.state_cache import KeptStates, Place
from cpm_core.segmentation.method import MethodState

Apply = Callable[[int, MethodState, RunAction], MethodState]
"""Gives the next state of a run from a state and an action, always the same one."""


class RecordedSteps(Generic[RunAction]):
    """The steps of all runs and their branches, any of which can be recovered.

    States take at most `budget` bytes, but the first one of each run and the current one are always kept.
    """

    def __init__(self, apply: Apply[RunAction], budget: int) -> None:
        self.edition = 0
        """Changes whenever something is recorded, renamed or removed."""
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
    def branches(self) -> tuple[Branch, ...]:
        """All branches, the oldest first; the same tuple until a branch comes, goes, is renamed or changes its scale.

        Meanwhile the current branch may be longer than its `last` says.
        """
        return self._tree.outline

    @property
    def nodes(self) -> tuple[BranchNode[RunAction], ...]:
        """All branches with their actions, the oldest first."""
        return self._tree.nodes

    @property
    def steered(self) -> bool:
        """Whether there is more than one run that went on without a change to its end."""
        return len(self._tree) > 1 or any(node.steered for node in self._tree.nodes)

    def run_of(self, branch: int) -> int:
        """Number of the run that a branch belongs to."""
        return self._tree.known(branch).run

    @property
    def runs(self) -> tuple[int, ...]:
        """Numbers of the runs, the oldest first."""
        return tuple(root.run for root in self._tree.roots)

    def state(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """The state of a step, as `go` gives it, without going there."""
        node = self._tree.known(branch)
        return self._recover(node, min(max(step, self._tree.root(node.run).first), node.last), wanted)

    def kept_state(self, branch: int, step: int) -> MethodState | None:
        """The state of a step if it need not be computed again."""
        return self._kept.get(self._place(self._tree.known(branch), step))

    def rename(self, branch: int, name: str) -> None:
        """Give a branch another name; an empty one changes nothing."""
        node = self._tree.known(branch)
        if name.strip():
            node.name, node.renamed = name.strip(), True
            self._change()

    def _change(self) -> None:
        """The branches are others than before."""
        self.edition += 1
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
                state = self._apply(node.run, state, action)
            self._kept.put((its.identity, at), state)
        return state
