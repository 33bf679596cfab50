"""The scene store: the scene that a session shows, the state of its run, and the reports of the worker."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from operator import add
from typing import Any, TypeVar

from PySide6.QtCore import QObject, Signal, SignalInstance

from cpm_app.model.state.situation import Phase, RunStatus
from cpm_app.model.text.language import tr
from cpm_app.session.exchange.messages import (
    CommandFailed,
    FilesExported,
    ImageOpened,
    Reconstruction,
    ReconstructionFailed,
    Report,
    RunContinued,
    RunFailed,
    RunsKept,
    SeedsFound,
    Snapshot,
    WarmedUp,
    WorkFinished,
)
from cpm_app.session.scene import Scene
from cpm_app.session.session_messages import (
    CONTOURS_CATEGORY,
    EDITING_CATEGORY,
    EXPORTING_CATEGORY,
    RUNNING_CATEGORY,
    SessionMessages,
)
from cpm_app.session.worker.commands import RunsRestored
from cpm_app.session.worker.requests import ForcesProbed, ImageShaded
from cpm_app.session.worker.worker_thread import WorkerThread
from cpm_core import Result
from cpm_core.numerics.types import Texts

R = TypeVar("R", bound=Report)

_ENDED_BY: Mapping[type[Report], Texts] = {
    ImageOpened: ("seeding", "restoring"), RunsRestored: ("restoring",), RunFailed: ("restoring",),
    SeedsFound: ("seeding",), WarmedUp: ("preparing",),
}  # fmt: skip
"""Activities that have ended once a report arrives."""

_STATUS_INTERVAL = 0.1
"""Time between two updates of the numbers in the window [s]."""

_SILENT_WAIT = 0.5
"""How long the contours of a run at rest may take before the window says that they are being made [s]."""


class _Deferrable:
    """A signal that can be deferred to the end of a block, and is then emitted once if it was requested there."""

    def __init__(self, signal: SignalInstance) -> None:
        self._signal = signal
        self._deferred = self._requested = False

    def request(self) -> None:
        """Emit the signal, now or at the end of the block."""
        if self._deferred:
            self._requested = True
        else:
            self._signal.emit()

    @contextmanager
    def defer(self) -> Iterator[None]:
        """Defer the signal to the end of the outermost block."""
        if self._deferred:
            yield
            return
        self._deferred, self._requested = True, False
        try:
            yield
        finally:
            self._deferred = False
            if self._requested:
                self._signal.emit()


class SceneStore(QObject):
    """The scene that a session shows and the state of its run, with signals for views.

    Snapshots and reports of the worker are taken once per display frame, checked, and dispatched.
    """

    scene_changed = Signal()
    """The scene has been replaced."""
    drawing_wanted = Signal()
    """The scene is to be drawn: it has been replaced, perhaps several times in one edit."""
    status_changed = Signal()
    """`Session.resolved` may have changed."""

    def __init__(self, worker_thread: WorkerThread, messages: SessionMessages, parent: QObject) -> None:
        super().__init__(parent)
        self._worker_thread, self._messages = worker_thread, messages
        self._busy: dict[str, str] = {}
        self._shown_at = 0.0
        self._waiting_since = math.inf
        self._run_status = RunStatus()
        self.scene = Scene()
        """The scene that is shown."""
        self.generation = 0
        """Number of the current run; snapshots and reports of other runs are not shown."""
        self.image_generation = 0
        """Number under which the image was opened."""
        self._written: tuple[FilesExported, ...] = ()
        """What has been written since an export was last requested."""
        messages.cleared.connect(self._on_messages_cleared)
        self._status_change, self._drawing = _Deferrable(self.status_changed), _Deferrable(self.drawing_wanted)
        self._listeners: dict[type[Report], list[Callable[[Any], object]]] = {}

    def set_scene(self, scene: Scene) -> None:
        """Show another scene."""
        self.scene = scene
        self.announce_scene()

    def announce_scene(self) -> None:
        """Announce that the scene has been replaced, and have it drawn."""
        self.scene_changed.emit()
        self._drawing.request()

    def announce_status(self) -> None:
        """Announce that `Session.resolved` may have changed."""
        self._status_change.request()

    @contextmanager
    def defer_status(self) -> Iterator[None]:
        """Announce a changed status only once, at the end: every action of the window is updated by it."""
        with self._status_change.defer():
            yield

    @contextmanager
    def draw_once(self) -> Iterator[None]:
        """Draw the scene only once, at the end of an edit, and announce a changed status after that."""
        with self._status_change.defer(), self._drawing.defer():
            yield

    def add_listener(self, kind: type[R], listener: Callable[[R], object]) -> None:
        """Call a listener with all reports of one kind from now on."""
        self._listeners.setdefault(kind, []).append(listener)

    def remove_listener(self, kind: type[R], listener: Callable[[R], object]) -> None:
        """Stop calling a listener."""
        self._listeners[kind].remove(listener)

    def dispatch_report(self, report: Report) -> None:
        """Call the listeners of a report's kind."""
        for take in tuple(self._listeners.get(type(report), ())):
            take(report)

    # The run

    @property
    def status(self) -> RunStatus:
        """State of the run."""
        busy = next(iter(self._busy.values()), "")
        return replace(self._run_status, busy=busy) if busy else self._run_status

    @property
    def result_is_due(self) -> bool:
        """Whether the run has ended, and what it has found is still being made."""
        found, reconstructor = self._run_status.found, self._worker_thread.run.reconstructor
        over = found is not None and not (isinstance(found, Result) and not found.stop_reason)
        going_on = not reconstructor.idle or bool(reconstructor.results)
        return self._run_status.phase == "finished" and not over and going_on

    def set_busy(self, activity: str, text: str) -> None:
        """Show `text` while an activity is in progress."""
        self._busy = {activity: text} | {key: value for key, value in self._busy.items() if key != activity}
        self.announce_status()

    def set_phase(self, phase: Phase) -> None:
        """Set the phase of the run, which the user has started or stopped."""
        self._run_status = replace(self._run_status, phase=phase)
        self.announce_status()

    def clear_run(self, method: str = "cpm") -> None:
        """Clear everything shown of the previous run; `method` is the name of the next run's method."""
        self._run_status = RunStatus(phase="ready", method=method)
        self._messages.set_error("", CONTOURS_CATEGORY)
        self._update_scene(snapshot=None, reconstruction=None, probed=None)
        self.announce_status()

    def poll_worker(self) -> None:
        """Take the messages of the worker; drop those of another run or image."""
        for report in self._worker_thread.take_reports():
            self._on_report(report)
        snapshot = self._worker_thread.run.snapshots.take()
        if snapshot is not None and snapshot.generation == self.generation:
            self._on_snapshot(snapshot)
        contours = self._worker_thread.run.reconstructor.results.take()
        if contours is not None and contours.generation == self.generation:
            self._on_contours(contours)
        overlays = self._worker_thread.run.overlays.take()
        if overlays is not None and overlays.generation == self.image_generation:
            self._messages.set_error(overlays.error, "overlays")
            self._update_scene(overlays=overlays.arrays)
        self._show_waiting()

    def _show_waiting(self) -> None:
        """Say that the contours or the surface of a run at rest are being made, if that takes a while."""
        if self._run_status.phase == "running" or self._worker_thread.run.reconstructor.idle:
            waited, self._waiting_since = self._waiting_since < math.inf, math.inf
            if self._busy.pop("reconstructing", "") or waited:
                self.announce_status()
            return
        image, now = self.scene.image, time.perf_counter()
        self._waiting_since = min(self._waiting_since, now)
        if now - self._waiting_since > _SILENT_WAIT and "reconstructing" not in self._busy and image is not None:
            in_volume = len(image.spacing) == 3
            text = tr("Making the surface…") if in_volume else tr("Making the contours…")
            self.set_busy("reconstructing", text)

    def _on_messages_cleared(self, category: str) -> None:
        if category == EXPORTING_CATEGORY:
            self._written = ()

    def _on_contours(self, found: Reconstruction | ReconstructionFailed) -> None:
        if isinstance(found, ReconstructionFailed):
            trouble = found.message
            if self.scene.contours:
                trouble = tr("{trouble} The contours that are shown are those of an earlier step.", trouble=trouble)
            self._messages.set_error(trouble, CONTOURS_CATEGORY)
            return
        self._messages.set_error("", CONTOURS_CATEGORY)
        self._run_status = replace(self._run_status, found=found.result)
        self._update_scene(reconstruction=found)
        self.announce_status()

    def _update_scene(self, **parts: Any) -> None:
        """Replace parts of the scene."""
        self.set_scene(replace(self.scene, **parts))

    def _on_snapshot(self, snapshot: Snapshot) -> None:
        before, state, metrics = self._run_status.phase, snapshot.state, snapshot.metrics
        held: Phase = "paused" if before == "finished" else before  # the run has gone back from its end
        self._run_status = replace(
            self._run_status,
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
        self._update_scene(snapshot=snapshot, timeline=snapshot.timeline)
        now = time.perf_counter()
        if self._run_status.phase != "running" or before != "running" or now - self._shown_at >= _STATUS_INTERVAL:
            self._shown_at = now
            self.announce_status()

    def _on_report(self, report: Report) -> None:
        for what in _ENDED_BY.get(type(report), ()):
            self._busy.pop(what, None)
        match report:
            case RunsRestored(generation, _, True) if generation == self.generation:
                # the state that is shown may have been taken before this report
                self._run_status = replace(
                    self._run_status, phase="finished" if self._run_status.stop_reason else "paused"
                )
            case RunFailed(generation, sentence) if generation == self.generation:
                self._run_status = replace(self._run_status, phase="paused" if self._run_status.count else "ready")
                self._messages.show(sentence, True, RUNNING_CATEGORY)
            case RunsKept(generation, timeline) if generation == self.generation and not self._run_status.started:
                self._update_scene(timeline=timeline)
            case RunContinued(generation) if generation == self.generation:
                self._run_status = replace(self._run_status, phase="running")
            case SeedsFound(generation, image_seeds, sentence):
                if sentence:
                    self._messages.show(sentence, True, EDITING_CATEGORY)
                if generation == self.image_generation:
                    self._update_scene(image_seeds=image_seeds)
            case FilesExported():
                self._written = (*self._written, report)
                names = [str(self._written[0].path), *(each.path.name for each in self._written[1:])]
                contents = (f" ({each.counts})" if each.counts else "" for each in self._written)
                path, count = "; ".join(map(add, names, contents)), sum(each.files for each in self._written)
                several = tr("{count} files written: {path}", count=count, path=path)
                written = several if count > 1 else tr("Written: {path}", path=path)
                self._messages.show(written, category=EXPORTING_CATEGORY)
            case CommandFailed(sentence, topic):
                self._messages.show(sentence, True, topic)
            case ForcesProbed():
                self._messages.set_error(report.error, "forces")
                self._update_scene(probed=report)
            case ImageShaded():
                self._update_scene(shaded=report)
            case WorkFinished(then):
                then()
        self.dispatch_report(report)
        self.announce_status()
