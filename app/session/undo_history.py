"""Undo: one mechanism for everything that changes the document."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable
from dataclasses import dataclass, field, replace
from typing import Any

from app.model.document.document import Document, ImageReference
from app.model.parameters.controls import choice_controls, controls, value_of
from app.model.text.language import tr, written
from cpm_core import Parameters
from cpm_core.shapes import Charge, Everywhere, Interest, Limit, Points

DEEPEST = 500


@dataclass(eq=False, slots=True)
class Erasure:
    """The particles that a gesture takes away from a run, which undo brings back: its number among all of them.

    `sources` are the drawn shapes that it takes away, as far as particles of the run come from them.
    """

    number: int
    sources: Counter[Hashable] = field(default_factory=Counter)


@dataclass(frozen=True, slots=True)
class Change:
    """A change that can be undone.

    Changes in a row with the same gesture, such as the drag of a slider, become one; an empty one never merges.
    """

    name: str
    before: Document
    after: Document
    gesture: str = ""
    erasure: Erasure | None = None
    words: ChangeInWords = field(init=False)
    """What has become what."""

    def __post_init__(self) -> None:
        # here, and not when the history is shown: that is after every step of a drag
        object.__setattr__(self, "words", described(self.name, self.before, self.after))


@dataclass(frozen=True, slots=True)
class Turned:
    """What undo or redo leads to: a document, and the changes on the way there, and whether they were undone."""

    document: Document
    changes: tuple[Change, ...]
    back: bool


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

    def go_to(self, done: int) -> Turned | None:
        """Undo or redo until so many changes are done; None if they are."""
        turned, last = None, len(self._done)
        while last != done and (step := self.undo() if done < last else self.redo()) is not None:
            turned = step if turned is None else replace(step, changes=(*turned.changes, *step.changes))
            last = len(self._done)
        return turned

    def push(self, change: Change) -> None:
        """Record a change that has been made."""
        self._undone.clear()
        if self._open and change.gesture and self._done and self._done[-1].gesture == change.gesture:
            known = self._done.pop()
            merged = replace(known, after=change.after, name=change.name, erasure=known.erasure or change.erasure)
            if merged.before != merged.after or merged.erasure is not None:
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

    def undo(self) -> Turned | None:
        """Take the last change back, if there is one."""
        return self._turn(self._done, self._undone, back=True)

    def redo(self) -> Turned | None:
        """Repeat the change that was undone last, if there is one."""
        return self._turn(self._undone, self._done, back=False)

    def on(self, image: ImageReference | None) -> History:
        """The same history for the image as it has been opened again, by another path perhaps.

        Without the erasures of particles, whose runs have ended with the image.
        """
        for changes in (self._done, self._undone):
            if any(change.after.image != image or change.erasure is not None for change in changes):
                changes[:] = [
                    Change(change.name, replace(change.before, image=image), replace(change.after, image=image))
                    for change in changes if change.before != change.after
                ]  # fmt: skip
        return self

    def _turn(self, source: list[Change], target: list[Change], *, back: bool) -> Turned | None:
        self._open = False
        if not source:
            return None
        change = source.pop()
        target.append(change)
        return Turned(change.before if back else change.after, (change,), back)


_ICONS: tuple[tuple[Any, str], ...] = (
    (type(None), "bin"), (Charge, "attract"), (Interest, "region"), (Limit, "barrier"), (Everywhere, "everywhere"),
    (Points, "points"), (object, "circle"),
)  # fmt: skip
"""Icons of shapes, those of their tools, and of none; the first kind that a shape is of counts."""

_PARTS = (("objects", "objects"), ("hand_edits", "edit_contours"), ("marks", "contours"), ("mode", "run"))
"""Other parts of a document and the icons of their changes."""


@dataclass(frozen=True, slots=True)
class ChangeInWords:
    """A change of a document: a line of text, and the name of its icon, empty for none."""

    text: str
    icon: str = ""


def described(name: str, before: Document, after: Document) -> ChangeInWords:
    """What has become what; the name of the change if there is no short way to say it."""
    text = name[:1].upper() + name[1:]
    if before.parameters != after.parameters:
        return ChangeInWords(_parameter(before, after) or text, "slider")
    if before.shapes != after.shapes:
        added = next((shape for shape in after.shapes if shape not in before.shapes), None)
        return ChangeInWords(text, next(icon for kind, icon in _ICONS if isinstance(added, kind)))
    icons = (icon for part, icon in _PARTS if getattr(before, part) != getattr(after, part))
    return ChangeInWords(text, next(icons, ""))


def _parameter(before: Document, after: Document) -> str:
    """The values of the only parameter that differs; empty if there are several."""
    old, new = _values(before.parameters), _values(after.parameters)
    changed = [name for name, value in old.items() if value != new[name]]
    if len(changed) != 1:
        return ""
    return tr("{name} {old} → {new}").format(name=changed[0], old=old[changed[0]], new=new[changed[0]])


def _values(parameters: Parameters) -> dict[str, str]:
    """The values of all parameters as they are shown, by their titles."""
    found: dict[str, str] = {}
    for control in controls():
        value = value_of(parameters, control.name)
        number = isinstance(value, float | int) and (
            dict(control.words).get(value) or written(f"{value:.{control.decimals}f}")
        )
        found[control.title] = number or tr("auto")
    for choice in choice_controls():
        chosen = value_of(parameters, choice.name)
        found[choice.title] = next(title for value, title, _ in choice.choices if value == chosen)
    return found
