"""A page of a stack that is not open: its document and what belongs to it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from app.model.document.document import Document
from app.session.document.undo_history import Change, History
from cpm_core.formats.sessions.session_file import SessionFile
from cpm_core.pages.page import StartingLine
from cpm_core.shapes import Polygon, Shape, Start, Stroke
from cpm_core.shapes.document_shapes import starts_of


@dataclass(frozen=True, eq=False, slots=True)
class KeptPage:
    """What is kept of a page while another one is open.

    Attributes
    ----------
    file : SessionFile
        All that a session file would hold of it: document, runs, view.
    document : Document
        Its document.
    history : History
        What can be undone in it.
    known : Document or None
        The document that the session file has of it; None where it has another one.
    given : tuple of Start
        Starts that it was given by what was found on the page before, which a person has not drawn.
    runs_unsaved : bool
        Whether there are runs that are in no file.
    """

    file: SessionFile
    document: Document
    history: History = field(default_factory=History)
    known: Document | None = None
    given: tuple[Start, ...] = ()
    runs_unsaved: bool = False

    @property
    def own_start(self) -> bool:
        """Whether a person has drawn where its run starts."""
        return has_own_start(self.document, self.given)

    @property
    def unsaved(self) -> bool:
        """Whether closing would lose something of it."""
        return self.runs_unsaved or self.document != self.known

    def saved(self) -> KeptPage:
        """The same page after it has been written to a file."""
        return replace(self, known=self.document, runs_unsaved=False)

    def seen(self, view: Mapping[str, Any]) -> SessionFile:
        """Its content with the view of another page, so that paging does not move the image."""
        return replace(self.file, view=dict(view))


def has_own_start(document: Document, given: tuple[Start, ...]) -> bool:
    """Whether a person has drawn where the run of a document starts, which was `given` starts."""
    return bool(document.starts) and document.starts != given


def started_by(document: Document, starts: tuple[Start, ...]) -> Document:
    """A document with these starts in place of its own; limits and charges stay."""
    others = tuple(shape for shape in document.shapes if not isinstance(shape, Start))
    shapes: tuple[Shape, ...] = (*starts, *others)
    return replace(document, shapes=shapes)


def starts_along(lines: tuple[StartingLine, ...]) -> tuple[Start, ...]:
    """Starts along the contours of the page before, as shapes that can be seen and changed."""
    drawn = [(Polygon if line.closed else Stroke)(line.corners) for line in lines]
    return starts_of(drawn)


def bare(document: Document) -> Document:
    """What a page takes over from another one: drawing, parameters and mode, but nothing that belongs to contours."""
    return Document(document.image, document.shapes, document.parameters, mode=document.mode)


def with_change(history: History, change: Change) -> History:
    """A history with one more change, unless that changes nothing."""
    if change.before != change.after:
        history.push(change)
    return history
