"""Undo: one mechanism for everything that changes the document."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Hashable
from dataclasses import replace

from cpm_app.model.document.document import Document, ImageReference
from cpm_core.numerics.types import frozen
from cpm_core.objects.segmented import SegmentedObject

MAX_UNDO_CHANGES = 500
"""Largest number of changes that can be undone."""


@frozen
class TimelinePlace:
    """A step of the timeline of an image.

    Attributes
    ----------
    image_generation : int
        Number under which the image was opened.
    run : int
        Number by which the window knows the run.
    branch, step : int
        Where it is on the timeline.
    sources : Counter
        The sources of its particles.
    at_rest : bool
        Whether the run had ended there.
    """

    image_generation: int
    run: int
    branch: int
    step: int
    sources: Counter[Hashable]
    at_rest: bool


@frozen
class Change:
    """A change that can be undone.

    Successive changes with the same gesture, such as the drag of a slider, are merged; an empty gesture never merges.
    `place_before` and `place_after` are where the run was when the change was made and when it was undone last; undo
    and redo go back there if the run was at rest, or if the change `erases` particles.
    """

    name: str
    before: Document
    after: Document
    gesture: str = ""
    erases: bool = False
    place_before: TimelinePlace | None = None
    place_after: TimelinePlace | None = None


class UndoHistory:
    """Undo stack and redo stack of changes of the document."""

    def __init__(self) -> None:
        self._done: list[Change] = []
        self._undone: list[Change] = []
        self._open = False

    @property
    def undo_name(self) -> str:
        """Name of the change that undo takes back, empty if there is none."""
        return self._done[-1].name if self._done else ""

    @property
    def undone_document(self) -> Document | None:
        """The document that undo would restore; None if there is nothing to undo."""
        return self._done[-1].before if self._done else None

    @property
    def redo_name(self) -> str:
        """Name of the change that redo repeats, empty if there is none."""
        return self._undone[-1].name if self._undone else ""

    @property
    def undone_objects(self) -> tuple[SegmentedObject, ...]:
        """The objects after the change that redo repeats."""
        return self._undone[-1].after.objects.items if self._undone else ()

    def push(self, change: Change) -> None:
        """Record a change that has been made."""
        self._undone.clear()
        if self._open and change.gesture and self._done and self._done[-1].gesture == change.gesture:
            known = self._done.pop()
            merged = replace(known, after=change.after, name=change.name, erases=known.erases or change.erases)
            if merged.before != merged.after or merged.erases:
                self._done.append(merged)
            else:
                self._open = False
            return
        self._done.append(change)
        self._open = bool(change.gesture)
        del self._done[:-MAX_UNDO_CHANGES]

    def end_gesture(self) -> None:
        """End a gesture: the next change is separate."""
        self._open = False

    def undo(self, place: TimelinePlace | None) -> Change | None:
        """Take the last change back, if there is one; `place` is where the run is after it."""
        return self._move_last_change(self._done, self._undone, lambda change: replace(change, place_after=place))

    def redo(self, place: TimelinePlace | None) -> Change | None:
        """Repeat the change that was undone last, if there is one; `place` is where the run is before it."""
        at_rest = place is not None and place.at_rest
        return self._move_last_change(
            self._undone, self._done, lambda change: replace(change, place_before=place) if at_rest else change
        )

    def move_to_image(self, image: ImageReference | None) -> UndoHistory:
        """Apply the history to the image as it has been reopened, perhaps by another path.

        Erasures of particles are dropped, because their runs have ended with the image.
        """
        for changes in (self._done, self._undone):
            if any(change.after.image != image or change.erases for change in changes):
                changes[:] = [
                    Change(change.name, replace(change.before, image=image), replace(change.after, image=image))
                    for change in changes if change.before != change.after
                ]  # fmt: skip
        return self

    def forget_deleted(self, document: Document) -> Document:
        """Return the document shown without what has been deleted, as a run begins; so is what undo and redo restore.

        Where undo goes back to an earlier run, that stays as it was. A deletion that was undone before is not among
        what is forgotten: once it is repeated, it is one since the run began.
        """
        count = len(document.objects.deleted)
        if not count:
            return document

        def forget(one: Document) -> Document:
            return replace(one, objects=replace(one.objects, deleted=one.objects.deleted[count:]))

        for changes in (self._undone, self._done):
            for at in reversed(range(len(changes))):
                change = changes[at]
                earlier = changes is self._done and change.place_before is not None and change.place_before.at_rest
                before = change.before if earlier else forget(change.before)
                changes[at] = replace(change, before=before, after=forget(change.after))
                if earlier:
                    break
        return forget(document)

    def _move_last_change(
        self, source: list[Change], target: list[Change], note_place: Callable[[Change], Change]
    ) -> Change | None:
        self._open = False
        if source:
            target.append(note_place(source.pop()))
            return target[-1]
        return None
