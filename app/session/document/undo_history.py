"""Undo: one mechanism for everything that changes the document."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from app.model.document.changes import ChangeInWords, in_words
from app.model.document.document import Document, ImageReference

DEEPEST = 500


@dataclass(frozen=True, slots=True)
class Change:
    """A change that can be undone.

    Changes in a row with the same gesture, such as the drag of a slider, become one; an empty one never merges.
    """

    name: str
    before: Document
    after: Document
    gesture: str = ""
    words: ChangeInWords = field(init=False)
    """What has become what."""

    def __post_init__(self) -> None:
        # here, and not when the history is shown: that is after every step of a drag
        object.__setattr__(self, "words", in_words(self.name, self.before, self.after))


class History:
    """Changes that are done and undone."""

    def __init__(self) -> None:
        self._done: list[Change] = []
        self._undone: list[Change] = []
        self._open = False

    @property
    def undo_name(self) -> str:
        """Name of the change that undo takes back, empty if there is none."""
        return self._done[-1].name if self._done else ""

    @property
    def redo_name(self) -> str:
        """Name of the change that redo repeats, empty if there is none."""
        return self._undone[-1].name if self._undone else ""

    @property
    def changes(self) -> tuple[ChangeInWords, ...]:
        """All changes, the oldest first: those done, then those undone that can be done again."""
        return tuple(change.words for change in (*self._done, *reversed(self._undone)))

    @property
    def done(self) -> int:
        """Number of changes that are done."""
        return len(self._done)

    def go_to(self, done: int) -> Document | None:
        """The document with so many changes done; None if it is the current one."""
        document = None
        while self._done and len(self._done) > done:
            document = self.undo()
        while self._undone and len(self._done) < done:
            document = self.redo()
        return document

    def push(self, change: Change) -> None:
        """Record a change that has been made."""
        self._undone.clear()
        if self._open and change.gesture and self._done and self._done[-1].gesture == change.gesture:
            merged = replace(self._done.pop(), after=change.after, name=change.name)
            if merged.before != merged.after:
                self._done.append(merged)
            else:
                self._open = False
            return
        self._done.append(change)
        self._open = bool(change.gesture)
        del self._done[:-DEEPEST]

    def seal(self) -> None:
        """End a gesture: the next change is separate."""
        self._open = False

    def undo(self) -> Document | None:
        """The document before the last change, or None."""
        return self._turn(self._done, self._undone, back=True)

    def redo(self) -> Document | None:
        """The document after the change last undone, or None."""
        return self._turn(self._undone, self._done, back=False)

    def on(self, image: ImageReference | None) -> History:
        """The same history for the image as it has been opened again, by another path perhaps."""
        for changes in (self._done, self._undone):
            if changes and changes[-1].after.image != image:
                changes[:] = [_on(change, image) for change in changes]
        return self

    def _turn(self, source: list[Change], target: list[Change], *, back: bool) -> Document | None:
        self._open = False
        if not source:
            return None
        change = source.pop()
        target.append(change)
        return change.before if back else change.after


def _on(change: Change, image: ImageReference | None) -> Change:
    return replace(change, before=replace(change.before, image=image), after=replace(change.after, image=image))
