"""The timeline: every step of every run can be gone to, and a run can continue from any of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from app.model.text.language import tr
from app.session.timeline.branches import BranchNode, RunAction
from app.session.timeline.recording import Recording
from app.session.timeline.state_cache import Place
from cpm_core.segmentation.method import MethodState


class Timeline(Recording[RunAction]):
    """The steps of all runs and their branches, and the current one."""

    def restart(self, run: int) -> None:
        """Go to the first step of a run."""
        root = self._tree.root(run)
        self._return_to(root, root.first)

    def go(self, branch: int, step: int, wanted: Callable[[], bool] = lambda: True) -> MethodState | None:
        """Go to a step, or to the nearest one of its branch, and return its state, exactly as it was.

        `wanted` is called between steps that have to be repeated; where it returns False, nothing changes and the
        result is None. ValueError when there is no such branch.
        """
        node = self._tree.known(branch)
        step = min(max(step, self._tree.root(node.run).first), node.last)
        state = self._recover(node, step, wanted)
        if state is not None:
            self._tree.touch()
            self._set_place(node, step)
            self._kept.put(self._place(node, step), state)
        return state

    def restore(
        self,
        nodes: Sequence[BranchNode[RunAction]],
        begun: Mapping[int, MethodState],
        states: Mapping[Place, MethodState],
    ) -> None:
        """Remove everything and take over branches, with the first states of their runs and others that are known."""
        self.clear()
        for node in nodes:
            self._tree.adopt(node)
        for root in self._tree.roots:
            state = begun[root.run]
            for action in root.actions[0]:
                state = self._apply(root.run, state, action)
            self._kept.fix(f"first of {root.run}", (root.identity, root.first))
            self._kept.put((root.identity, root.first), state)
        for (branch, step), state in states.items():
            self._kept.put(self._place(self._tree.known(branch), step), state)
        self._make_room()

    def drop(self, branch: int) -> None:
        """Remove a branch; steps that others have in common with it stay with them.

        The branch that leaves it last takes over its beginning. If the run is on a removed step, it goes back to where
        that branch began, or to the end of the run before. ValueError when there is no such branch, or no other one.
        """
        node = self._tree.known(branch)
        if len(self._tree) == 1:
            raise ValueError(tr("The only run cannot be deleted."))
        descendant = self._tree.descendant(node)
        if descendant is not None:
            self._inherit(node, descendant)
        elif node.parent is None:
            self._drop_run(node)
            return
        else:
            parent = self._tree.parent(node)
            self._kept.hand_over(node.identity, parent.identity, node.first - 1)
            if self._node is node:
                self._return_to(self._tree.owner(parent, node.first), node.first)
        self._tree.remove(node)
        self._change()

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

    def _drop_run(self, node: BranchNode[RunAction]) -> None:
        """Remove a run of one branch; if it is the current one, go to the end of the one before."""
        roots = [root for root in self._tree.roots if root is not node]
        before = [root for root in roots if root.identity < node.identity] or roots
        was_here = self._node is node
        self._remove_run(node.run)
        if was_here:
            self._return_to(before[-1], before[-1].last)
