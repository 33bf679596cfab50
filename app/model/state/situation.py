"""The situation: document, selection and run together, and the conditions under which actions make sense."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from app.model.document.document import Document
from app.model.state.status import RunStatus


@dataclass(frozen=True, slots=True)
class Situation:
    """All that decides what the window shows and enables.

    Attributes
    ----------
    document : Document
        What the user means.
    status : RunStatus
        How the run stands.
    undo_name, redo_name : str
        Names of what undo and redo would do, empty when there is nothing.
    selected : int or None
        Index of the selected shape.
    """

    document: Document = field(default_factory=Document)
    status: RunStatus = field(default_factory=RunStatus)
    undo_name: str = ""
    redo_name: str = ""
    selected: int | None = None


Condition = Callable[[Situation], bool]


def always(situation: Situation) -> bool:
    """Whatever the situation."""
    return True


def has_image(situation: Situation) -> bool:
    """An image is open."""
    return situation.document.image is not None


def has_shapes(situation: Situation) -> bool:
    """Something is drawn."""
    return bool(situation.document.shapes)


def has_selection(situation: Situation) -> bool:
    """A shape is selected."""
    return situation.selected is not None


def can_undo(situation: Situation) -> bool:
    """There is a way back."""
    return bool(situation.undo_name)


def can_redo(situation: Situation) -> bool:
    """There is a way forth."""
    return bool(situation.redo_name)


def is_started(situation: Situation) -> bool:
    """A run has been begun."""
    return situation.status.started


def is_running(situation: Situation) -> bool:
    """Steps are being taken."""
    return situation.status.phase == "running"


def has_particles(situation: Situation) -> bool:
    """Something of a run has been seen."""
    return situation.status.moved


def has_contours(situation: Situation) -> bool:
    """Contours have been found."""
    return situation.status.closed + situation.status.open > 0


def can_step(situation: Situation) -> bool:
    """A single step can be taken: not while it runs, nor after the end of a run for which nothing has changed."""
    status = situation.status
    over = status.phase == "finished" and not (status.stale or status.steered)
    return has_image(situation) and status.phase != "running" and not over
