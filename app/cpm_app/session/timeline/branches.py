"""Branches of runs, and runs as a session keeps them: how each began, its branches, and a few of its states."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, field
from itertools import takewhile

from cpm_app.model.document.document import Document
from cpm_app.session.timeline.timeline_nodes import BranchMetrics, BranchStep, TimelineNode
from cpm_core import Parameters
from cpm_core.numerics.types import frozen, record
from cpm_core.segmentation import MethodState
from cpm_core.shapes import Points, Start


@frozen
class TimelineBranch:
    """A run, or a branch of one.

    Attributes
    ----------
    identity : int
        Its number, unique on the timeline.
    name : str
        Displayed name.
    parent : int or None
        The branch that it leaves; None for the first branch of a run.
    first, last : int
        Step at which it leaves its parent, and the last one recorded.
    scales : tuple of tuple of int
        First step and number of each scale that begins among its own steps.
    run : int
        Number of the run that it belongs to.
    renamed : bool
        Whether the user has named it.
    """

    identity: int
    name: str
    parent: int | None
    first: int
    last: int
    scales: tuple[tuple[int, int], ...] = ()
    run: int = 0
    renamed: bool = False


@dataclass(eq=False)
class Branch:
    """A branch with the last node of each step, from the first step of its run; branches share their common beginning.

    `scales` are first steps and numbers of its scales, `figures` has its figures for plots; `steered` is whether it
    leaves another branch, or its state or parameters were changed between steps.
    """

    identity: int
    name: str
    run: int
    nodes: list[TimelineNode]
    scales: list[tuple[int, int]]
    steered: bool = False
    renamed: bool = False
    figures: BranchMetrics = field(default_factory=BranchMetrics)

    @property
    def last(self) -> int:
        """Its last step."""
        return len(self.nodes) - 1

    def node_at(self, step: int) -> TimelineNode:
        """Return the node of a step, or of the nearest one."""
        return self.nodes[min(max(step, 0), self.last)]

    def count_common_nodes(self, other: Branch) -> int:
        """Count the nodes that it has in common with another branch."""
        most = range(min(len(self.nodes), len(other.nodes)))
        return bisect_left(most, True, key=lambda at: self.nodes[at] is not other.nodes[at])

    def scales_until(self, step: int) -> list[tuple[int, int]]:
        """Return the scales that begin up to a step."""
        return [mark for mark in self.scales if mark[0] <= step]


NO_BRANCH = Branch(0, "", 0, [], [])
"""The branch that a run is on before it has begun."""


def describe_branches(branches: Iterable[Branch]) -> tuple[TimelineBranch, ...]:
    """Describe branches for the window, the oldest first.

    The parent of each is the older branch of its run that it shares the most nodes with, None if it shares none.
    """
    lines = tuple(branches)

    def describe_branch(line: Branch) -> TimelineBranch:
        older = takewhile(lambda other: other is not line, lines)
        parent = max((other for other in older if other.run == line.run), key=line.count_common_nodes, default=None)
        scales, first = line.scales, 0
        if parent is not None:
            at = line.count_common_nodes(parent)
            both = at < min(len(line.nodes), len(parent.nodes))
            first = at if both and parent.nodes[at] in line.nodes[at].nodes_of_step else at - 1
        if parent is None or first < 0:
            parent, first = None, 0
        else:
            scales = [mark for mark in scales if mark[0] > first]
        leaves = None if parent is None else parent.identity
        return TimelineBranch(line.identity, line.name, leaves, first, line.last, tuple(scales), line.run, line.renamed)

    return tuple(map(describe_branch, lines))


@record
class StoredRun:
    """A run: its first document, the starts and points its particles come from, and its branches, the oldest first."""

    document: Document
    sources: Counter[Hashable]
    branches: tuple[Branch, ...]


@record
class StoredRuns:
    """All runs, the oldest first, the shown branch and step, and states that need not be recomputed.

    `parameters` are those with which contours of the shown state are made, which may have changed since its step.
    """

    runs: tuple[StoredRun, ...] = ()
    shown_step: BranchStep | None = None
    parameters: Parameters | None = None
    states: Mapping[BranchStep, MethodState] = field(default_factory=dict)


def starts_from_sources(sources: Counter[Hashable]) -> tuple[Start, ...]:
    """Return the starts that sources of particles belong to, all points as one; see `Document.start_counts`."""
    points = tuple(source for source in sources.elements() if isinstance(source, tuple))
    starts = tuple(source for source in sources.elements() if isinstance(source, Start))
    return (*starts, Points(points)) if points else starts
