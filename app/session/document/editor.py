"""The document under the user's hands: what it is, what is selected, and the way back."""

from __future__ import annotations

from collections.abc import Callable

from app.model.document.document import Document
from app.session.document.undo_history import Change, History


class Editor:
    """Document, selection and history, kept consistent with each other."""

    def __init__(self) -> None:
        self.document = Document()
        self.selected: int | None = None
        self._history = History()

    @property
    def undo_name(self) -> str:
        """Name of what undo would take back."""
        return self._history.undo_name

    @property
    def redo_name(self) -> str:
        """Name of what redo would do again."""
        return self._history.redo_name

    @property
    def changes(self) -> tuple[tuple[str, ...], int]:
        """Names of all changes, and how many of them are done; the others are undone."""
        return self._history.names, self._history.done

    def begin(self, document: Document) -> None:
        """Begin anew with a document, without a way back to the one before."""
        self._history.clear()
        self.selected = None
        self.document = document

    def edit(self, name: str, edit: Callable[[Document], Document], gesture: str) -> None:
        """Change the document; what changes nothing is not remembered."""
        after = edit(self.document)
        if after != self.document:
            self._history.push(Change(name, self.document, after, gesture))
            self._show(after)

    def seal(self) -> None:
        """End a gesture."""
        self._history.seal()

    def undo(self) -> None:
        """Take back the last edit."""
        self._show(self._history.undo())

    def redo(self) -> None:
        """Do again what was undone last."""
        self._show(self._history.redo())

    def go_to(self, done: int) -> None:
        """Take back or do again until so many of the changes are done."""
        self._show(self._history.go_to(done))

    def next_shape(self) -> int | None:
        """Index of the shape drawn after the selected one, the first after the last."""
        count = len(self.document.shapes)
        if not count:
            return None
        return 0 if self.selected is None else (self.selected + 1) % count

    def _show(self, document: Document | None) -> None:
        if document is not None:
            self.document = document
            if self.selected is not None and self.selected >= len(document.shapes):
                self.selected = None
