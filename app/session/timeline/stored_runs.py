"""Runs as a session keeps them: how each began, what was done in it, and a few of its states."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field

from app.model.document.document import Document
from app.session.timeline.moments import BranchStep, RunAction
from cpm_core.numerics import Array, Position
from cpm_core.segmentation import MethodState


@dataclass(frozen=True, eq=False, slots=True)
class StoredBranch:
    """A branch: its number, its name, what it leaves and where, and the actions of its steps.

    `steps` holds the actions of each step, of the first one only those that changed its state; `figures`, shape (M, K),
    are the rows of its record for plots.
    """

    number: int
    name: str
    renamed: bool
    parent: int | None
    first: int
    steps: tuple[tuple[RunAction, ...], ...]
    scales: tuple[tuple[int, int], ...]
    figures: Array


@dataclass(frozen=True, eq=False, slots=True)
class StoredRun:
    """A run: its first document, the sources of its particles until now, and its branches, parents first."""

    document: Document
    drawn: Counter[Hashable]
    branches: tuple[StoredBranch, ...]


@dataclass(frozen=True, eq=False, slots=True)
class StoredRuns:
    """All runs, the oldest first, branch and step that are shown, and states that need not be computed again.

    `numbers` are the numbers of contours, each with a place where its contour passes.
    """

    runs: tuple[StoredRun, ...] = ()
    here: BranchStep | None = None
    states: Mapping[BranchStep, MethodState] = field(default_factory=dict)
    numbers: Mapping[int, Position] = field(default_factory=dict)
