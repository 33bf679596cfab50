"""Editing of the document: its selection and its undo history."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from PySide6.QtCore import QObject

from app.model.document import edits
from app.model.document.changes import ChangeInWords
from app.model.document.document import Document
from app.model.text.language import from_core, tr
from app.model.text.reasons import reason
from app.session.scene import ReviewedContours
from app.session.signals import EDITING, RUNNING, SessionSignals
from app.session.undo_history import Change, Erasure, History, Turned


class Editing(SessionSignals):
    """Edits the document of the scene, and keeps the selection and the history consistent with it."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._history = History()

    @property
    def document(self) -> Document:
        """The document of the scene."""
        return self.scene.document

    @property
    def selected(self) -> int | None:
        """Index of the selected shape."""
        return self.scene.selected

    @property
    def undo_name(self) -> str:
        """Name of the change that undo takes back, empty if there is none."""
        return self._history.undo_name

    @property
    def redo_name(self) -> str:
        """Name of the change that redo repeats, empty if there is none."""
        return self._history.redo_name

    @property
    def changes(self) -> tuple[tuple[ChangeInWords, ...], int]:
        """All changes to the document in words, and how many of them are done; the others are undone."""
        return self._history.changes, self._history.done

    @property
    def history(self) -> History:
        """What can be undone and redone, as it is kept for a page that is left."""
        return self._history

    def use_history(self, history: History) -> None:
        """Take up the history of the document that is open, as it was left."""
        self._history = history
        self.show_status()

    def edit(
        self, name: str, edit: Callable[[Document], Document], gesture: str = "", erasure: Erasure | None = None
    ) -> None:
        """Change the document in a way that can be undone.

        `name` is what follows "Undo" in the menu. Edits in a row with the same gesture are undone together, and with
        them the `erasure` of particles. A `ValueError` of `edit` is shown to the user and changes nothing.
        """
        before = self.document
        try:
            after = edit(before)
        except ValueError as error:
            self.say(reason(error), True, EDITING)
            return
        if after != before or erasure is not None:
            self._history.push(Change(name, before, after, gesture, erasure))
            self._use(after, complete=not gesture)
        if after == before and erasure is not None:
            self._announce()

    def seal(self) -> None:
        """End a gesture: the next edit is undone separately."""
        self._history.seal()
        self._end_gesture()

    def undo(self) -> None:
        """Take back the last edit."""
        self._turn(self._history.undo())

    def redo(self) -> None:
        """Repeat the edit that was undone last."""
        self._turn(self._history.redo())

    def go_to(self, done: int) -> None:
        """Undo or redo until so many of the `changes` are done."""
        self._turn(self._history.go_to(done))

    def select(self, index: int | None) -> None:
        """Select a shape, or none; none, too, in place of one that could not be drawn."""
        if index is not None and index >= len(self.document.shapes):
            index = None
        if index != self.selected:
            self.show(replace(self.scene, selected=index))
            self.document_changed.emit(self.document)
            self.show_status()

    def select_next(self) -> None:
        """Select the shape drawn after the selected one, the first after the last."""
        count = len(self.document.shapes)
        self.select(None if not count else 0 if self.selected is None else (self.selected + 1) % count)

    def delete_selected(self) -> None:
        """Remove the selected shape."""
        index = self.selected
        if index is not None:
            name = tr("delete {shape}").format(shape=from_core(self.document.shapes[index].title))
            self.select(None)
            self.edit(name, lambda document: edits.delete_shape(document, index))

    def begin_document(self, document: Document, before: Document | None = None) -> None:
        """Use another document, with an empty undo history, in place of the present one or of one `before` it."""
        self._history = History()
        self._scene = replace(self.scene, selected=None)
        self._use(document, before=before)

    def _turn(self, turned: Turned | None) -> None:
        """Use the document that undo or redo leads to, and bring particles back or take them away again."""
        if turned is None:
            return
        erasures = [change.erasure for change in turned.changes if change.erasure is not None]
        if erasures:
            self._turn_erasures(erasures, turned.back)
        same = turned.document == self.document
        self._use(turned.document)
        if same:
            self._announce()

    def _announce(self) -> None:
        """The history has changed, and the document has not."""
        self.document_changed.emit(self.document)
        self.show_status()

    def _turn_erasures(self, erasures: Sequence[Erasure], back: bool) -> None:
        """Particles that were erased come back, or go again."""

    def _follow(self, before: Document, after: Document, complete: bool) -> None:
        """The document has changed; unless `complete`, the gesture that changes it continues."""

    def _end_gesture(self) -> None:
        """A gesture has ended."""

    def _use(self, document: Document | None, complete: bool = True, before: Document | None = None) -> None:
        before, scene = before or self.document, self.scene
        if document is None or document == before:
            return
        self.attempt(EDITING, RUNNING)  # an edit may be the remedy for why a run did not begin
        selected = scene.selected
        if selected is not None and selected >= len(document.shapes):
            selected = None
        contours = scene.contours
        if document.marks != before.marks:
            contours = ReviewedContours.of(contours.tracked, document.marks)
        self._scene = replace(scene, document=document, selected=selected, contours=contours)
        self._follow(before, document, complete)
        self.scene_changed.emit()
        self.document_changed.emit(document)
        self.show_status()
