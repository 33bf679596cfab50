"""Signals and reports by which views follow a session."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Signal

from app.model.text.language import shortened
from app.session.exchange.messages import Report
from app.session.scene import Scene

R = TypeVar("R", bound=Report)

OPENING, RUNNING, EDITING, SAVING = "opening", "running", "editing", "saving"
EXPORTING, FILMING, CONTOURS = "exporting", "filming", "contours"
"""Kinds of attempts that messages belong to."""

RECOVERY, JOURNAL, PREFERENCES, UNEXPECTED = "recovery", "journal", "preferences", "unexpected"

OF_THE_PROGRAM = (RECOVERY, JOURNAL, PREFERENCES, UNEXPECTED)
"""Topics of messages that do not concern the open image, and stay when another one is opened."""


class SessionSignals(QObject):
    """The scene, the signals that views follow, and the reports for single features."""

    scene_changed = Signal()
    """The scene has been replaced."""
    image_changed = Signal()
    """Another image has been opened."""
    document_changed = Signal(object)
    """The document has been replaced: Document."""
    status_changed = Signal()
    """`resolved` may have changed."""
    said = Signal(str, bool, str)
    """A sentence for the user, whether it is an error message, and the kind of attempt that it belongs to, or ""."""
    attempted = Signal(str)
    """Something of this kind is attempted again: what was said about the last attempt no longer applies."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.scene = Scene()
        """The scene that is shown."""
        self.generation = 0
        """Number of the current run; snapshots and reports of other runs are not shown."""
        self.image_generation = 0
        """Number under which the image was opened."""
        self._troubles: dict[str, str] = {}
        self._gathering = self._gathered = False
        self._listeners: dict[type[Report], list[Callable[[Any], object]]] = {}

    def show(self, scene: Scene) -> None:
        """Show another scene."""
        self.scene = scene
        self.scene_changed.emit()

    def show_status(self) -> None:
        """Announce that `resolved` may have changed."""
        if self._gathering:
            self._gathered = True
        else:
            self.status_changed.emit()

    @contextmanager
    def gathering(self) -> Iterator[None]:
        """Announce a changed status once at the end, since all actions of the window follow it."""
        self._gathering, self._gathered = True, False
        try:
            yield
        finally:
            self._gathering = False
            if self._gathered:
                self.status_changed.emit()

    def listen(self, kind: type[R], take: Callable[[R], object]) -> None:
        """Call `take` with all reports of one kind from now on."""
        self._listeners.setdefault(kind, []).append(take)

    def stop_listening(self, kind: type[R], take: Callable[[R], object]) -> None:
        """Call `take` no longer."""
        self._listeners[kind].remove(take)

    def pass_on(self, report: Report) -> None:
        """Pass a report to the listeners of its kind."""
        for take in tuple(self._listeners.get(type(report), ())):
            take(report)

    def say(self, sentence: str, trouble: bool = False, topic: str = "") -> None:
        """Show one sentence to the user; it belongs to an attempt of a kind, such as `EXPORTING`."""
        self.said.emit(shortened(sentence), trouble, topic)

    def trouble(self, sentence: str, topic: str) -> None:
        """Tell what work that is done again and again failed with, and with an empty sentence that it succeeded.

        The same sentence is shown only once, so that it can be dismissed; success takes it back.
        """
        before = self._troubles.pop(topic, "")
        if sentence:
            self._troubles[topic] = sentence
            if sentence != before:
                self.say(sentence, True, topic)
        elif before:
            self.attempt(topic)

    def attempt(self, *topics: str) -> None:
        """Announce that something is attempted again; see `attempted`."""
        for topic in topics:
            self.attempted.emit(topic)
