"""Runs as stored in a session file: how each began, its actions, and a few of its states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping
from dataclasses import field

from cpm_app.model.document.document import Document
from cpm_app.session.timeline.timeline_nodes import BranchStep, RunAction
from cpm_core.numerics import Array
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


@record
class StoredBranch:
    """A branch with the actions of its steps; for the first step only those that changed its state.

    `figures`, shape (K, N), are the recorded figures for plots, None where they are left out.
    """

    branch: TimelineBranch
    steps: tuple[tuple[RunAction, ...], ...]
    figures: Array | None = None


@record
class StoredRun:
    """A run: its first document, the starts and points its particles come from, and its branches, parents first."""

    document: Document
    sources: Counter[Hashable]
    branches: tuple[StoredBranch, ...]


@record
class StoredRuns:
    """All runs, the oldest first, the shown branch and step, and states that need not be recomputed."""

    runs: tuple[StoredRun, ...] = ()
    shown_step: BranchStep | None = None
    states: Mapping[BranchStep, MethodState] = field(default_factory=dict)


def starts_from_sources(sources: Counter[Hashable]) -> tuple[Start, ...]:
    """Return the starts that sources of particles belong to, all points as one; see `Document.start_counts`."""
    points = tuple(source for source in sources.elements() if isinstance(source, tuple))
    starts = tuple(source for source in sources.elements() if isinstance(source, Start))
    return (*starts, Points(points)) if points else starts
