"""The branches of a timeline: a tree for each run."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

from app.model.text.language import tr

RunAction = TypeVar("RunAction")
"""Leads from one state to the next; equal actions lead from the same state to the same next one."""


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
    """

    identity: int
    name: str
    parent: int | None
    first: int
    last: int
    scales: tuple[tuple[int, int], ...] = ()
    run: int = 0


@dataclass(eq=False, slots=True)
class BranchNode(Generic[RunAction]):
    """The recorded actions of the steps of a branch, from its first one on.

    Each step has the action that it was taken with and those that changed its state afterwards; the first step, whose
    state is the parent's, has only the latter.
    """

    identity: int
    name: str
    parent: int | None
    first: int
    actions: list[tuple[RunAction, ...]]
    run: int
    scales: list[tuple[int, int]] = field(default_factory=list)
    renamed: bool = False
    steered: bool = False

    @property
    def last(self) -> int:
        """The last step recorded."""
        return self.first + len(self.actions) - 1

    def add(self, action: RunAction) -> None:
        """Add a step."""
        self.steered = self.steered or (len(self.actions) > 1 and action != self.actions[1][0])
        self.actions.append((action,))

    def amend(self, action: RunAction) -> None:
        """Change the state of the last step."""
        self.steered = True
        self.actions[-1] = (*self.actions[-1], action)

    @property
    def empty(self) -> bool:
        """Whether nothing has been done from its first step on."""
        return self.actions == [()]

    def outline(self) -> Branch:
        """The branch as the window shows it."""
        return Branch(self.identity, self.name, self.parent, self.first, self.last, tuple(self.scales), self.run)


class Lineage(Generic[RunAction]):
    """Branches by number: a run leaves no other branch, each other one leaves a branch of its run at some step."""

    def __init__(self) -> None:
        self._nodes: dict[int, BranchNode[RunAction]] = {}
        self._numbered = 0
        self._named = [0, 0]
        self._outline: tuple[Branch, ...] | None = None

    def __len__(self) -> int:
        return len(self._nodes)

    @property
    def outline(self) -> tuple[Branch, ...]:
        """All branches as the window shows them; the same tuple until `touch`."""
        if self._outline is None:
            self._outline = tuple(node.outline() for node in self._nodes.values())
        return self._outline

    @property
    def nodes(self) -> tuple[BranchNode[RunAction], ...]:
        """All branches, the oldest first."""
        return tuple(self._nodes.values())

    @property
    def roots(self) -> tuple[BranchNode[RunAction], ...]:
        """The first branch of each run, the oldest first."""
        return tuple(node for node in self._nodes.values() if node.parent is None)

    def root(self, run: int) -> BranchNode[RunAction]:
        """The first branch of a run."""
        return next(node for node in self.roots if node.run == run)

    def of_run(self, run: int) -> tuple[BranchNode[RunAction], ...]:
        """The branches of a run."""
        return tuple(node for node in self._nodes.values() if node.run == run)

    def touch(self) -> None:
        """Make the outline again when it is next read."""
        self._outline = None

    def clear(self) -> None:
        """Remove all branches."""
        self._nodes.clear()
        self._numbered = 0
        self._named = [0, 0]
        self.touch()

    def known(self, branch: int) -> BranchNode[RunAction]:
        """A branch by its number; ValueError where there is none."""
        if branch not in self._nodes:
            raise ValueError(tr("There is no branch {number} (any more).").format(number=branch))
        return self._nodes[branch]

    def parent(self, node: BranchNode[RunAction]) -> BranchNode[RunAction]:
        """The branch that another one leaves."""
        assert node.parent is not None
        return self._nodes[node.parent]

    def open(
        self, parent: BranchNode[RunAction] | None, first: int, changes: tuple[RunAction, ...]
    ) -> BranchNode[RunAction]:
        """Add a branch from a step of another one, with the changes to its state there; without a parent a run."""
        self._numbered += 1
        branches = parent is not None
        self._named[branches] += 1
        name = (tr("Branch {number}") if branches else tr("Run {number}")).format(number=self._named[branches])
        leaves, run = (None, self._numbered) if parent is None else (parent.identity, parent.run)
        node = BranchNode(self._numbered, name, leaves, first, [changes], run)
        self._nodes[node.identity] = node
        self.touch()
        return node

    def adopt(self, node: BranchNode[RunAction]) -> None:
        """Add a branch as it was; parents come before others."""
        self._nodes[node.identity] = node
        self._numbered = max(self._numbered, node.identity, node.run)
        branches, number = node.parent is not None, node.name.rpartition(" ")[2]
        self._named[branches] = max(self._named[branches] + 1, int(number) if number.isdecimal() else 0)
        first = node.actions[1:2]
        node.steered = bool(node.actions[0]) or any([step] != first for step in node.actions[1:])
        self.touch()

    def remove(self, node: BranchNode[RunAction]) -> None:
        """Remove a branch that no other one leaves."""
        del self._nodes[node.identity]
        self.touch()

    def owner(self, node: BranchNode[RunAction], step: int) -> BranchNode[RunAction]:
        """The branch in which a step of a branch is recorded: itself or an ancestor."""
        while node.parent is not None and (step < node.first or (step == node.first and not node.actions[0])):
            node = self._nodes[node.parent]
        return node

    def forks(self, node: BranchNode[RunAction], step: int) -> bool:
        """Whether another branch leaves a branch at this step."""
        return any(other.parent == node.identity and other.first == step for other in self._nodes.values())

    def repeated(self, here: BranchNode[RunAction], step: int, action: RunAction) -> BranchNode[RunAction] | None:
        """The branch that has already gone on from a step by this action, `here` before others."""
        if step == here.last and len(self._nodes) == 1:
            return None
        owner = self.owner(here, step)
        for node in (here, *self._nodes.values()):
            own = node.first <= step < node.last
            if own and node.actions[step + 1 - node.first] == (action,) and self.owner(node, step) is owner:
                return node
        return None

    def mark(self, node: BranchNode[RunAction], step: int, scale: int) -> None:
        """Record the scale of a new step if it is another one than before."""
        if (node.parent is None and not node.scales) or scale != self._scale(node, step):
            node.scales.append((step, scale))
            self.touch()

    def descendant(self, node: BranchNode[RunAction]) -> BranchNode[RunAction] | None:
        """The branch that takes over the beginning of another: of the last that leave it, one without changes there.

        ValueError when there are several, and all of them have changed the state.
        """
        children = [other for other in self._nodes.values() if other.parent == node.identity]
        descendant = max(children, key=lambda child: (child.first, not child.actions[0]), default=None)
        if (
            descendant is not None
            and descendant.actions[0]
            and sum(child.first == descendant.first for child in children) > 1
        ):
            message = tr("{name} cannot be deleted: several branches begin with its step {step}.")
            raise ValueError(message.format(name=node.name, step=descendant.first))
        return descendant

    def hand_over(self, node: BranchNode[RunAction], descendant: BranchNode[RunAction]) -> None:
        """Give the descendant of a branch the common steps, and make it the parent of the other branches."""
        fork = descendant.first
        common = node.actions[: fork - node.first + 1]
        descendant.actions = [*common[:-1], (*common[-1], *descendant.actions[0]), *descendant.actions[1:]]
        descendant.scales = [mark for mark in node.scales if mark[0] <= fork] + descendant.scales
        descendant.first, descendant.parent = node.first, node.parent
        for other in self._nodes.values():
            if other.parent == node.identity:
                other.parent = descendant.identity
        self.touch()

    def _scale(self, node: BranchNode[RunAction], step: int) -> int:
        """Scale of a step of a branch, as far as it is recorded."""
        for first, scale in reversed(node.scales):
            if first <= step:
                return scale
        return self._scale(self.parent(node), min(step, node.first))
