"""The situation: document, selection and run together, and the conditions of actions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from app.model.document.document import Document
from app.model.state.status import RunStatus


@dataclass(frozen=True, slots=True)
class Situation:
    """Everything that decides what the window shows and enables.

    The names of undo and redo are empty when there is nothing to undo or redo; `selected` is the index of a shape.
    """

    document: Document = field(default_factory=Document)
    status: RunStatus = field(default_factory=RunStatus)
    undo_name: str = ""
    redo_name: str = ""
    selected: int | None = None


Condition = Callable[[Situation], bool]


def always(situation: Situation) -> bool:
    """In any situation."""
    return True


def has_image(situation: Situation) -> bool:
    """An image is open."""
    return situation.document.image is not None


def has_shapes(situation: Situation) -> bool:
    """There are shapes."""
    return bool(situation.document.shapes)


def has_selection(situation: Situation) -> bool:
    """A shape is selected."""
    return situation.selected is not None


def can_undo(situation: Situation) -> bool:
    """There is a change to undo."""
    return bool(situation.undo_name)


def can_redo(situation: Situation) -> bool:
    """There is a change to redo."""
    return bool(situation.redo_name)


def is_started(situation: Situation) -> bool:
    """There is a run."""
    return situation.status.started


def is_running(situation: Situation) -> bool:
    """Steps are being taken."""
    return situation.status.phase == "running"


def has_particles(situation: Situation) -> bool:
    """Particles of a run have been shown."""
    return situation.status.moved


def has_contours(situation: Situation) -> bool:
    """Contours have been found."""
    return situation.status.closed + situation.status.open > 0


def can_step(situation: Situation) -> bool:
    """A single step can be taken: not during a run, nor after the end of a run for which nothing has changed."""
    status = situation.status
    over = status.phase == "finished" and not (status.stale or status.steered)
    return has_image(situation) and status.phase != "running" and not over
