"""State of the timeline, as the window shows it."""

from __future__ import annotations

from dataclasses import dataclass

from app.session.timeline.branches import Branch
from cpm_core.parameters import Parameters


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
    fallen : tuple of str
        Names of the runs that were removed to make room.
    edition : int
        Changes whenever something is recorded, renamed or removed.
    steered : bool
        Whether there is more than one run that went on without a change to its end.
    began : int
        Generation with which the current run began, 0 before there is one.
    """

    branches: tuple[Branch, ...] = ()
    branch: int = 0
    used: int = 0
    budget: int = 0
    kept: int = 0
    parameters: Parameters | None = None
    fallen: tuple[str, ...] = ()
    edition: int = 0
    steered: bool = False
    began: int = 0
