"""The branches of a timeline: what each has recorded, and what it has in common with those it comes from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Generic, TypeVar

from app.model.text.language import tr

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


@dataclass(eq=False, slots=True)
class Line(Generic[Deed]):
    """What is recorded of a branch: the deeds of its steps from the first on.

    Each step has the deed that it was taken with and those by which its state was changed afterwards; of the first
    step, whose state is the parent's, only the latter.
    """

    identity: int
    name: str
    parent: int | None
    first: int
    deeds: list[tuple[Deed, ...]]
    scales: list[tuple[int, int]] = field(default_factory=list)

    @property
    def last(self) -> int:
        """The last step recorded."""
        return self.first + len(self.deeds) - 1

    def outline(self) -> Branch:
        """What is told of it."""
        return Branch(self.identity, self.name, self.parent, self.first, self.last, tuple(self.scales))


class Lineage(Generic[Deed]):
    """Branches by number, each of which but the first leaves another one at some step."""

    def __init__(self) -> None:
        self._lines: dict[int, Line[Deed]] = {}
        self._numbered = 0
        self._outline: tuple[Branch, ...] | None = None

    def __len__(self) -> int:
        return len(self._lines)

    @property
    def outline(self) -> tuple[Branch, ...]:
        """All branches as they are told of; the same tuple until something is touched."""
        if self._outline is None:
            self._outline = tuple(line.outline() for line in self._lines.values())
        return self._outline

    @property
    def root(self) -> Line[Deed]:
        """The branch that begins with the run."""
        return next(line for line in self._lines.values() if line.parent is None)

    def touch(self) -> None:
        """Something is to be told anew."""
        self._outline = None

    def clear(self) -> None:
        """Forget all branches."""
        self._lines.clear()
        self._numbered = 0
        self.touch()

    def known(self, branch: int) -> Line[Deed]:
        """A branch by its number; ValueError where there is none."""
        if branch not in self._lines:
            raise ValueError(tr("There is no branch {number} (any more).").format(number=branch))
        return self._lines[branch]

    def parent(self, line: Line[Deed]) -> Line[Deed]:
        """The branch that one leaves, which is not the first."""
        assert line.parent is not None
        return self._lines[line.parent]

    def open(self, parent: Line[Deed] | None, first: int, changes: tuple[Deed, ...]) -> Line[Deed]:
        """Begin a branch with a step of another one, and with what is changed there."""
        self._numbered += 1
        name = tr("Branch {number}").format(number=self._numbered)
        line = Line(self._numbered, name, None if parent is None else parent.identity, first, [changes])
        self._lines[line.identity] = line
        self.touch()
        return line

    def remove(self, line: Line[Deed]) -> None:
        """Forget a branch from which no other comes any more."""
        del self._lines[line.identity]
        self.touch()

    def owner(self, line: Line[Deed], step: int) -> Line[Deed]:
        """The branch that a step of a branch is recorded in: itself, or one that it comes from."""
        while line.parent is not None and (step < line.first or (step == line.first and not line.deeds[0])):
            line = self._lines[line.parent]
        return line

    def forks(self, line: Line[Deed], step: int) -> bool:
        """Whether another branch leaves one with this step."""
        return any(other.parent == line.identity and other.first == step for other in self._lines.values())

    def repeated(self, here: Line[Deed], step: int, deed: Deed) -> Line[Deed] | None:
        """The branch, the one given before others, that has already gone on from its step by this deed."""
        if step == here.last and len(self._lines) == 1:
            return None
        owner = self.owner(here, step)
        for line in (here, *self._lines.values()):
            own = line.first <= step < line.last
            if own and line.deeds[step + 1 - line.first] == (deed,) and self.owner(line, step) is owner:
                return line
        return None

    def mark(self, line: Line[Deed], step: int, scale: int) -> None:
        """Tell the scale of a step just recorded; where it is another one than before, it is remembered."""
        if (line.parent is None and not line.scales) or scale != self._scale(line, step):
            line.scales.append((step, scale))
            self.touch()

    def heir(self, line: Line[Deed]) -> Line[Deed] | None:
        """Who would take the beginning of a branch over: of those that leave it last, one that changed nothing there.

        Raises
        ------
        ValueError
            When there are several, all of which have changed something.
        """
        children = [other for other in self._lines.values() if other.parent == line.identity]
        heir = max(children, key=lambda child: (child.first, not child.deeds[0]), default=None)
        if heir is not None and heir.deeds[0] and sum(child.first == heir.first for child in children) > 1:
            told = tr("{name} cannot be deleted: several branches begin with its step {step}.")
            raise ValueError(told.format(name=line.name, step=heir.first))
        return heir

    def bequeath(self, line: Line[Deed], heir: Line[Deed]) -> None:
        """Let the heir of a branch have all that both have in common, and be what others come from."""
        fork = heir.first
        common = line.deeds[: fork - line.first + 1]
        heir.deeds = [*common[:-1], (*common[-1], *heir.deeds[0]), *heir.deeds[1:]]
        heir.scales = [mark for mark in line.scales if mark[0] <= fork] + heir.scales
        heir.first, heir.parent = line.first, line.parent
        for other in self._lines.values():
            if other.parent == line.identity:
                other.parent = heir.identity
        self.touch()

    def _scale(self, line: Line[Deed], step: int) -> int:
        """Scale that a branch is at with a step, as far as it is known."""
        for begun, scale in reversed(line.scales):
            if begun <= step:
                return scale
        return self._scale(self.parent(line), min(step, line.first))
