"""The branches of a timeline: what each has recorded, and what it has in common with those it comes from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

from app.model.text.language import tr

RunAction = TypeVar("RunAction")
"""What leads from one state to the next; actions that are equal lead from the same state to the same one."""


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


@dataclass(eq=False, slots=True)
class BranchNode(Generic[RunAction]):
    """What is recorded of a branch: the actions of its steps from the first on.

    Each step has the action that it was taken with and those by which its state was changed afterwards; of the first
    step, whose state is the parent's, only the latter.
    """

    identity: int
    name: str
    parent: int | None
    first: int
    actions: list[tuple[RunAction, ...]]
    scales: list[tuple[int, int]] = field(default_factory=list)

    @property
    def last(self) -> int:
        """The last step recorded."""
        return self.first + len(self.actions) - 1

    def outline(self) -> Branch:
        """What is told of it."""
        return Branch(self.identity, self.name, self.parent, self.first, self.last, tuple(self.scales))


class Lineage(Generic[RunAction]):
    """Branches by number, each of which but the first leaves another one at some step."""

    def __init__(self) -> None:
        self._lines: dict[int, BranchNode[RunAction]] = {}
        self._numbered = 0
        self._outline: tuple[Branch, ...] | None = None

    def __len__(self) -> int:
        return len(self._lines)

    @property
    def outline(self) -> tuple[Branch, ...]:
        """All branches as they are told of; the same tuple until something is touched."""
        if self._outline is None:
            self._outline = tuple(node.outline() for node in self._lines.values())
        return self._outline

    @property
    def root(self) -> BranchNode[RunAction]:
        """The branch that begins with the run."""
        return next(node for node in self._lines.values() if node.parent is None)

    def touch(self) -> None:
        """Something is to be told anew."""
        self._outline = None

    def clear(self) -> None:
        """Forget all branches."""
        self._lines.clear()
        self._numbered = 0
        self.touch()

    def known(self, branch: int) -> BranchNode[RunAction]:
        """A branch by its number; ValueError where there is none."""
        if branch not in self._lines:
            raise ValueError(tr("There is no branch {number} (any more).").format(number=branch))
        return self._lines[branch]

    def parent(self, node: BranchNode[RunAction]) -> BranchNode[RunAction]:
        """The branch that one leaves, which is not the first."""
        assert node.parent is not None
        return self._lines[node.parent]

    def open(
        self, parent: BranchNode[RunAction] | None, first: int, changes: tuple[RunAction, ...]
    ) -> BranchNode[RunAction]:
        """Begin a branch with a step of another one, and with what is changed there."""
        self._numbered += 1
        name = tr("Branch {number}").format(number=self._numbered)
        node = BranchNode(self._numbered, name, None if parent is None else parent.identity, first, [changes])
        self._lines[node.identity] = node
        self.touch()
        return node

    def remove(self, node: BranchNode[RunAction]) -> None:
        """Forget a branch from which no other comes any more."""
        del self._lines[node.identity]
        self.touch()

    def owner(self, node: BranchNode[RunAction], step: int) -> BranchNode[RunAction]:
        """The branch that a step of a branch is recorded in: itself, or one that it comes from."""
        while node.parent is not None and (step < node.first or (step == node.first and not node.actions[0])):
            node = self._lines[node.parent]
        return node

    def forks(self, node: BranchNode[RunAction], step: int) -> bool:
        """Whether another branch leaves one with this step."""
        return any(other.parent == node.identity and other.first == step for other in self._lines.values())

    def repeated(self, here: BranchNode[RunAction], step: int, action: RunAction) -> BranchNode[RunAction] | None:
        """The branch, the one given before others, that has already gone on from its step by this action."""
        if step == here.last and len(self._lines) == 1:
            return None
        owner = self.owner(here, step)
        for node in (here, *self._lines.values()):
            own = node.first <= step < node.last
            if own and node.actions[step + 1 - node.first] == (action,) and self.owner(node, step) is owner:
                return node
        return None

    def mark(self, node: BranchNode[RunAction], step: int, scale: int) -> None:
        """Tell the scale of a step just recorded; where it is another one than before, it is remembered."""
        if (node.parent is None and not node.scales) or scale != self._scale(node, step):
            node.scales.append((step, scale))
            self.touch()

    def descendant(self, node: BranchNode[RunAction]) -> BranchNode[RunAction] | None:
        """The branch that takes over the beginning of one: of those that leave it last, one that changed nothing there.

        Raises
        ------
        ValueError
            When there are several, all of which have changed something.
        """
        children = [other for other in self._lines.values() if other.parent == node.identity]
        descendant = max(children, key=lambda child: (child.first, not child.actions[0]), default=None)
        if (
            descendant is not None
            and descendant.actions[0]
            and sum(child.first == descendant.first for child in children) > 1
        ):
            told = tr("{name} cannot be deleted: several branches begin with its step {step}.")
            raise ValueError(told.format(name=node.name, step=descendant.first))
        return descendant

    def hand_over(self, node: BranchNode[RunAction], descendant: BranchNode[RunAction]) -> None:
        """Let the descendant of a branch have all that both have in common, and be what others come from."""
        fork = descendant.first
        common = node.actions[: fork - node.first + 1]
        descendant.actions = [*common[:-1], (*common[-1], *descendant.actions[0]), *descendant.actions[1:]]
        descendant.scales = [mark for mark in node.scales if mark[0] <= fork] + descendant.scales
        descendant.first, descendant.parent = node.first, node.parent
        for other in self._lines.values():
            if other.parent == node.identity:
                other.parent = descendant.identity
        self.touch()

    def _scale(self, node: BranchNode[RunAction], step: int) -> int:
        """Scale that a branch is at with a step, as far as it is known."""
        for begun, scale in reversed(node.scales):
            if begun <= step:
                return scale
        return self._scale(self.parent(node), min(step, node.first))
