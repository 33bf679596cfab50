"""The runs of a session as stored in its file: collected from the worker when a run comes to rest."""

from __future__ import annotations

from concurrent.futures import Future

from PySide6.QtCore import QObject, QTimer, Signal

from cpm_app.session.exchange.messages import ImageOpened
from cpm_app.session.session import Session
from cpm_app.session.timeline.timeline import EMPTY_TIMELINE
from cpm_app.session.worker.commands import RunsCollected, RunsRestored, collect_runs
from cpm_core.numerics.types import Callback, JsonObject

_COLLECT_DELAY = 500
"""Time from a change of the runs until they are collected, together with all changes in between [ms]."""


class RunCollector(QObject):
    """Keeps the runs of a session as plain JSON, up to date with the worker."""

    changed = Signal()
    """The runs have been collected, or have been saved."""

    def __init__(self, session: Session) -> None:
        super().__init__(session)
        self.runs_json: JsonObject = {}
        self._session = session
        self._known = EMPTY_TIMELINE
        self._collected = self._saved = -1
        self._recovered = False
        self._then: list[Callback] = []
        self._timer = QTimer(self, singleShot=True, interval=_COLLECT_DELAY)
        self._timer.timeout.connect(self.collect_runs)
        session.store.scene_changed.connect(self._on_scene_changed)
        session.store.add_listener(ImageOpened, self._on_image_opened)
        session.store.add_listener(RunsCollected, self._on_runs_report)
        session.store.add_listener(RunsRestored, self._on_runs_report)

    @property
    def unsaved(self) -> bool:
        """Whether there are runs that are in no file and could not be reproduced by running again."""
        outline = self._known
        if not outline.branches or outline.edition == self._saved:
            return False
        status, taken = self._session.status, outline.parameters
        parameters = self._session.document.parameters
        other = taken is not None and taken.steering != parameters.steering
        return outline.steered or status.stale or (status.started and other)

    def collect_runs(self, on_collected: Callback | None = None) -> Future[RunsCollected]:
        """Collect the runs, and call `on_collected` afterwards; other threads can wait for the result."""
        if on_collected is not None:
            self._then.append(on_collected)
        self._timer.stop()
        session, found = self._session, Future[RunsCollected]()
        session.post_command(
            collect_runs(session.store.image_generation, dict(session.run_updater.sources_by_run), found)
        )
        return found

    def mark_saved(self, edition: int) -> None:
        """Record that the runs of this edition have been written to a file."""
        self._saved = edition
        self.changed.emit()

    def _on_scene_changed(self) -> None:
        """Collect changes of the runs soon, once they are at rest."""
        outline, known = self._session.scene.timeline, self._known
        if outline is known:
            return
        elsewhere, self._known = outline.branch != known.branch, outline
        running = self._session.status.phase == "running"
        if (elsewhere or outline.edition != self._collected) and not running and not self._timer.isActive():
            self._timer.start()

    def _on_runs_report(self, collected: RunsCollected | RunsRestored) -> None:
        here = collected.generation == self._session.store.image_generation
        if isinstance(collected, RunsRestored):
            self._saved = collected.edition if here and not self._recovered else self._saved
            return
        if here:
            self.runs_json, self._collected = collected.plain, collected.edition
        if collected.error:
            self._session.messages.show(collected.error, True)
        waiting, self._then = self._then, []
        for then in waiting:
            then()
        self.changed.emit()

    def _on_image_opened(self, opened: ImageOpened) -> None:
        self._timer.stop()
        self._recovered = opened.saved is not None and opened.saved.recovered
        self.runs_json = {} if opened.saved is None else opened.saved.file.runs
        self._known = EMPTY_TIMELINE
        self._collected = self._saved = -1
