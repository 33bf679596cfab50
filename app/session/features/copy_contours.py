"""Contours made ready for the clipboard, on a thread of their own."""

from __future__ import annotations

from dataclasses import dataclass

from app.model.text.language import tr
from app.session.exchange.messages import Report
from app.session.session import Session
from app.session.tasks.tasks import Task
from cpm_core.contours.review import apply
from cpm_core.formats import encoded


@dataclass(frozen=True, slots=True)
class Copied(Report):
    """What is to be put on the clipboard, as a file of this suffix would hold it."""

    suffix: str
    content: bytes


def copy_contours(session: Session, suffix: str) -> None:
    """Begin to make the contours found so far ready, without those that have been rejected."""
    result, marks = session.scene.contours.result, session.document.marks
    if result is None:
        session.say(tr("There are no contours to copy yet: let the particles run first."), True)
        return

    def work(task: Task) -> Report:
        return Copied(suffix, encoded(apply(result, marks), suffix))

    session.tasks.start(tr("Copying contours…"), work, "copying contours")
