"""The runs of a session as stored in its file: collected from the worker when a run comes to rest."""

from __future__ import annotations

from concurrent.futures import Future

from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.session.exchange.messages import Opened, RunsKept
from cpm_app.session.session import Session
from cpm_app.session.timeline.timeline import Outline
from cpm_app.session.worker.commands import RunsCollected, RunsRestored, collect_runs
from cpm_core.numerics.types import Callback, JsonObject

_QUIET = 500
"""Time from a change of the runs until they are collected, together with all changes in between [ms]."""


class RunKeeping(QObject):
    """Keeps the runs of a session as plain JSON, up to date with the worker."""

    changed = Signal()
    """The runs have been collected, or have been saved."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.plain: JsonObject = {}
        self._session = session
        self._outline: Outline | None = None
        self._collected = self._saved = -1
        self._recovered = False
        self._then: list[Callback] = []
        self._timer = QTimer(self, singleShot=True, interval=_QUIET)
        self._timer.timeout.connect(self.collect)
        session.scene_changed.connect(self._follow)
        session.listen(Opened, self._forget)
        session.listen(RunsKept, lambda kept: self._look(kept.timeline))
        session.listen(RunsCollected, self._take)
        session.listen(RunsRestored, self._take)

    @property
    def unsaved(self) -> bool:
        """Whether there are runs that are in no file and could not be reproduced by running again."""
        outline = self._outline
        if outline is None or not outline.branches or outline.edition == self._saved:
            return False
        status, taken = self._session.status, outline.parameters
        parameters = self._session.document.parameters
        other = taken is not None and taken.steering != parameters.steering
        return outline.steered or status.stale or (status.started and other)

    def collect(self, then: Callback | None = None) -> Future[RunsCollected]:
        """Collect the runs, and call `then` afterwards; other threads can wait for the result."""
        if then is not None:
            self._then.append(then)
        self._timer.stop()
        session, found = self._session, Future[RunsCollected]()
        session.post(collect_runs(session.image_generation, dict(session.live.executed), found))
        return found

    def saved(self, edition: int) -> None:
        """Record that the runs of this edition have been written to a file."""
        self._saved = edition
        self.changed.emit()

    def forget(self) -> None:
        """Treat the runs as saved."""
        self._saved = self._outline.edition if self._outline is not None else -1

    def _follow(self) -> None:
        snapshot = self._session.scene.snapshot
        if snapshot is not None:
            self._look(snapshot.timeline)

    def _look(self, outline: Outline) -> None:
        """Collect changes of the runs soon, once they are at rest."""
        if outline is self._outline:
            return
        elsewhere = self._outline is None or outline.branch != self._outline.branch
        self._outline = outline
        running = self._session.status.phase == "running"
        if (elsewhere or outline.edition != self._collected) and not running and not self._timer.isActive():
            self._timer.start()

    def _take(self, collected: RunsCollected | RunsRestored) -> None:
        here = collected.generation == self._session.image_generation
        if isinstance(collected, RunsRestored):
            self._saved = collected.edition if here and not self._recovered else self._saved
            return
        if here:
            self.plain, self._collected = collected.plain, collected.edition
        if collected.fault:
            self._session.say(collected.fault, True)
        waiting, self._then = self._then, []
        for then in waiting:
            then()
        self.changed.emit()

    def _forget(self, opened: Opened) -> None:
        self._timer.stop()
        self._recovered = opened.saved is not None and opened.saved.recovered
        self.plain, self._outline = ({} if opened.saved is None else opened.saved.file.runs), None
        self._collected = self._saved = -1
