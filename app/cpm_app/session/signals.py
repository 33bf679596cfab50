"""The scene store: the scene that a session shows, its signals for views, and the reports of the worker."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Signal

from cpm_app.model.state.situation import Phase, RunStatus
from cpm_app.model.text.language import elide_middle, tr
from cpm_app.session.exchange.messages import (
    CommandFailed,
    Compiling,
    Exported,
    Finished,
    Opened,
    Reconstruction,
    ReconstructionFailed,
    Report,
    RunFailed,
    SeedsFound,
    Snapshot,
    WarmedUp,
    WentOn,
)
from cpm_app.session.scene import NO_CONTOURS, ReviewedContours, Scene
from cpm_app.session.worker.commands import RunsRestored
from cpm_app.session.worker.requests import Probed, Shaded
from cpm_app.session.worker.worker_thread import WorkerThread
from cpm_core.numerics.types import Texts

R = TypeVar("R", bound=Report)

OPENING = "opening"
"""Category of messages about opening an image or a session."""

RUNNING = "running"
"""Category of messages about the run."""

EDITING = "editing"
"""Category of messages about edits of the document."""

SAVING = "saving"
"""Category of messages about saving the session."""

EXPORTING = "exporting"
"""Category of messages about exported files."""

FILMING = "filming"
"""Category of messages about animations."""

CONTOURS = "contours"
"""Category of messages about the reconstruction of contours."""

RECOVERY = "recovery"
"""Category of messages about work restored after a crash."""

JOURNAL = "journal"
"""Category of messages about the journal of unsaved work."""

UNEXPECTED = "unexpected"
"""Category of messages about unexpected errors."""

OF_THE_PROGRAM = (RECOVERY, JOURNAL, UNEXPECTED)
"""Categories of messages that do not concern the open image, and stay when another one is opened."""

_COMPILING_TEXT = tr("Preparing for the first run on this computer: {percent} %")

_ENDED_BY: Mapping[type[Report], Texts] = {
    Opened: ("seeding", "restoring"), RunsRestored: ("restoring",), RunFailed: ("restoring",),
    SeedsFound: ("seeding",), WarmedUp: ("preparing",),
}  # fmt: skip
"""Activities that have ended once a report arrives."""

_STATUS_INTERVAL = 0.1
"""Time between two updates of the numbers in the window [s]."""


class Board(QObject):
    """The scene that a session shows and the state of its run, with signals for views.

    Snapshots and reports of the worker are taken once per display frame, checked, and dispatched.
    """

    scene_changed = Signal()
    """The scene has been replaced."""
    image_changed = Signal()
    """Another image has been opened."""
    document_changed = Signal(object)
    """The document has been replaced: Document."""
    status_changed = Signal()
    """`resolved` may have changed."""
    said = Signal(str, bool, str)
    """A message for the user, whether it is an error, and its category, or ""."""
    attempted = Signal(str)
    """Messages of this category no longer apply, because what they were about is attempted again."""

    def __init__(self, worker_thread: WorkerThread, parent: QObject) -> None:
        super().__init__(parent)
        self._worker_thread = worker_thread
        self._busy: dict[str, str] = {}
        self._shown_at = 0.0
        self._known = RunStatus()
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
        """Announce a changed status only once, at the end: every action of the window is updated by it."""
        if self._gathering:
            yield
            return
        self._gathering, self._gathered = True, False
        try:
            yield
        finally:
            self._gathering = False
            if self._gathered:
                self.status_changed.emit()

    def listen(self, kind: type[R], take: Callable[[R], object]) -> None:
        """Call a listener with all reports of one kind from now on."""
        self._listeners.setdefault(kind, []).append(take)

    def stop_listening(self, kind: type[R], take: Callable[[R], object]) -> None:
        """Stop calling a listener."""
        self._listeners[kind].remove(take)

    def pass_on(self, report: Report) -> None:
        """Call the listeners of a report's kind."""
        for take in tuple(self._listeners.get(type(report), ())):
            take(report)

    def say(self, message: str, trouble: bool = False, category: str = "") -> None:
        """Show one sentence to the user; its category, such as `EXPORTING`, decides when it is cleared."""
        self.said.emit(elide_middle(message), trouble, category)

    def trouble(self, message: str, category: str) -> None:
        """Show the error of work that is repeated; an empty one clears it, because the work has succeeded.

        The same error is shown only once, so that the user can dismiss it.
        """
        before = self._troubles.pop(category, "")
        if message:
            self._troubles[category] = message
            if message != before:
                self.say(message, True, category)
        elif before:
            self.attempt(category)

    def attempt(self, *categories: str) -> None:
        """Clear the messages of some categories, because what they were about is attempted again."""
        for topic in categories:
            self.attempted.emit(topic)

    # The run

    @property
    def status(self) -> RunStatus:
        """State of the run."""
        return replace(self._known, busy=next(iter(self._busy.values()), ""))

    def busy(self, what: str, text: str) -> None:
        """Show `text` while an activity is in progress."""
        self._busy = {what: text} | {key: value for key, value in self._busy.items() if key != what}
        self.show_status()

    def phase(self, phase: Phase) -> None:
        """Set the phase of the run, which the user has started or stopped."""
        self._known = replace(self._known, phase=phase)
        self.show_status()

    def forget(self, method: str = "cpm") -> None:
        """Clear everything shown of the previous run; `method` is the name of the next run's method."""
        self._known = RunStatus(phase="ready", method=method)
        self.trouble("", CONTOURS)
        self._show(snapshot=None, reconstruction=None, contours=NO_CONTOURS, probed=None)
        self.show_status()

    def look(self) -> None:
        """Take the messages of the worker; drop those of another run or image."""
        for report in self._worker_thread.reports():
            self._take_report(report)
        snapshot = self._worker_thread.run.snapshots.take()
        if snapshot is not None and snapshot.generation == self.generation:
            self._take_snapshot(snapshot)
        contours = self._worker_thread.run.reconstructor.results.take()
        if contours is not None and contours.generation == self.generation:
            self._take_contours(contours)
        overlays = self._worker_thread.run.overlays.take()
        if overlays is not None and overlays.generation == self.image_generation:
            self.trouble(overlays.error, "overlays")
            self._show(overlays=overlays.arrays)

    def _take_contours(self, found: Reconstruction | ReconstructionFailed) -> None:
        if isinstance(found, ReconstructionFailed):
            trouble = found.message
            if self.scene.contours.items:
                trouble = tr("{trouble} The contours that are shown are those of an earlier step.", trouble=trouble)
            self.trouble(trouble, CONTOURS)
            return
        self.trouble("", CONTOURS)
        self._known = replace(self._known, found=found.result)
        reviewed = ReviewedContours.of(found.tracked, self.scene.document.marks)
        self._show(reconstruction=found, contours=reviewed)
        self.show_status()

    def _show(self, **parts: Any) -> None:
        """Replace parts of the scene."""
        self.show(replace(self.scene, **parts))

    def _take_snapshot(self, snapshot: Snapshot) -> None:
        before, state, metrics = self._known.phase, snapshot.state, snapshot.metrics
        held: Phase = "paused" if before == "finished" else before  # the run has gone back from its end
        self._known = replace(
            self._known,
            method=snapshot.method,
            phase="finished" if state.stop_reason else held,
            step=state.step,
            count=len(snapshot.position),
            scale=state.scale,
            epsilon=float(metrics.epsilon[-1]) if len(metrics.epsilon) else math.nan,
            stop_reason=state.stop_reason,
            converged=state.converged,
            steering=state.steering,
            steps_per_second=snapshot.steps_per_second,
        )
        self._show(snapshot=snapshot)
        now = time.perf_counter()
        if self._known.phase != "running" or before != "running" or now - self._shown_at >= _STATUS_INTERVAL:
            self._shown_at = now
            self.show_status()

    def _take_report(self, report: Report) -> None:
        for what in _ENDED_BY.get(type(report), ()):
            self._busy.pop(what, None)
        match report:
            case RunsRestored(generation, _, True) if generation == self.generation:
                # the state that is shown may have been taken before this report
                self._known = replace(self._known, phase="finished" if self._known.stop_reason else "paused")
            case RunFailed(generation, sentence) if generation == self.generation:
                self._known = replace(self._known, phase="paused" if self._known.count else "ready")
                self.say(sentence, True, RUNNING)
            case WentOn(generation) if generation == self.generation:
                self._known = replace(self._known, phase="running")
            case SeedsFound(generation, image_seeds, sentence):
                if sentence:
                    self.say(sentence, True, EDITING)
                if generation == self.image_generation:
                    self._show(image_seeds=image_seeds)
            case Exported(path, counts):
                written = tr("Written: {path}", path=path)
                self.say(f"{written} ({counts})" if counts else written, category=EXPORTING)
            case CommandFailed(sentence, topic):
                self.say(sentence, True, topic)
            case Compiling(percent) if "preparing" in self._busy:
                self._busy["preparing"] = _COMPILING_TEXT.format(percent=percent)
            case Probed():
                self.trouble(report.error, "forces")
                self._show(probed=report)
            case Shaded():
                self._show(shaded=report)
            case Finished(then):
                then()
        self.pass_on(report)
        self.show_status()
