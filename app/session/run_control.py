"""The run of a document: started, paused and changed by commands to the worker, and shown in every display frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from PySide6.QtCore import QObject, Qt, QTimer

from app.model.document.document import Document
from app.model.document.modes import MODES, needs_start
from app.model.state.resolve import FIRST_PACE, PACES, Resolved, resolve
from app.model.state.situation import RunStatus, Situation, can_step
from app.model.text.keys import with_keys
from app.model.text.language import tr
from app.session.core_functions import Core
from app.session.editing import Editing
from app.session.exchange.mailbox import Pacer
from app.session.live_edits import Live
from app.session.signals import RUNNING
from app.session.tasks.tasks import Tasks
from app.session.undo_history import Erasure
from app.session.updates import Progress
from app.session.worker.commands.run import Command, RunCall, Start
from app.session.worker.run import Run
from app.session.worker.worker_thread import WorkerThread
from cpm_core.segmentation.method import METHODS

FRAME = 16
"""Time between two display frames, in each of which reports of the worker are taken [ms]."""


class RunControl(Editing):
    """Controls the run of the document on the worker thread, and the tasks beside it."""

    def __init__(self, core: Core, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._worker_thread = WorkerThread(core)
        self.tasks = Tasks(self._worker_thread.report, self._wake, self)
        self.tasks.changed.connect(self.show_status)
        self._progress = Progress(self, self._worker_thread)
        self._numbered = 0
        self.live = Live(self, self._progress, self.post)
        self._overlays: frozenset[str] = frozenset()
        self._frames = Pacer()
        self._timer = QTimer(self)
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.setInterval(FRAME)
        self._timer.timeout.connect(self._frame)
        self.set_pace(PACES[FIRST_PACE])

    # State

    @property
    def status(self) -> RunStatus:
        """State of the run."""
        status = self._progress.status
        document, method = self.document, METHODS[status.method]
        other = status.method != MODES[document.mode].method
        stale = status.started and (other or (method.seeded and self.live.outdated(document)))
        steered = status.phase == "finished" and status.steering != method.steering(document.parameters)
        same = (stale, steered) == (status.stale, status.steered)
        return status if same else replace(status, stale=stale, steered=steered)

    @property
    def situation(self) -> Situation:
        """Everything that decides what the window shows and enables."""
        return Situation(self.document, self.status, self.undo_name, self.redo_name, self.selected)

    @property
    def resolved(self) -> Resolved:
        """What the window shows."""
        return resolve(self.situation)

    @property
    def frames_per_second(self) -> float:
        """Measured rate of display frames."""
        return self._frames.per_second

    @property
    def idle(self) -> bool:
        """Whether no work is going on and every report has been shown."""
        return self._worker_thread.idle and self.tasks.idle

    # Running

    def run(self) -> None:
        """Continue, or restart when the shapes have changed or the run is over and no parameter has changed since."""
        if not self._ready():
            return
        if self.status.phase != "running":
            self._start_if_needed()
            self._progress.phase("running")
            self.post(RunCall(self._generation, Run.go))

    def pause(self) -> None:
        """Stop after the current step."""
        if self.status.phase == "running":
            self.hold(RunCall(None, Run.halt))

    def toggle(self) -> None:
        """Pause when running, otherwise run."""
        if self.status.phase == "running":
            self.pause()
        else:
            self.run()

    def step(self) -> None:
        """Take one step; start a run first if there is none."""
        if can_step(self.situation) and self._ready():
            self._start_if_needed()
            self.hold(RunCall(self._generation, Run.go, 1))

    def reset(self) -> None:
        """Take the particles away and go back to the initialization; the run stays on the timeline."""
        if self.status.started:
            self.attempt(RUNNING)
            kept = self.status.step > 0
            self._generation = self._next_generation()
            self._progress.forget()
            self.post(RunCall(None, Run.discard, self._generation))
            if kept:
                kept_on = tr(
                    "The run is kept on the timeline: click it there, or press {key:timeline_last}, to go back to it."
                )
                self.say(with_keys(kept_on))

    def hold(self, command: Command) -> None:
        """Pause the run by a command after which it stays at some step."""
        self._progress.phase("paused")
        self.post(command)

    def set_pace(self, steps_per_second: float | None) -> None:
        """Limit the steps per second; None for no limit."""
        self.post(RunCall(None, Run.set_pace, steps_per_second))

    def want_overlay(self, name: str, wanted: bool) -> None:
        """Choose whether an overlay is kept up to date; see `app.session.worker.prepared_methods`."""
        before = self._overlays
        self._overlays = before | {name} if wanted else before - {name}
        if self._overlays != before:
            shown = {kept: array for kept, array in self.scene.overlays.items() if kept in self._overlays}
            if len(shown) < len(self.scene.overlays):
                self.show(replace(self.scene, overlays=shown))
            self.post(RunCall(None, Run.set_overlays, self._overlays))

    def post(self, command: Command) -> None:
        """Send a command to the worker."""
        self._worker_thread.post(command)
        self._wake()

    def close(self) -> None:
        """Stop everything and wait for the worker to end."""
        self._timer.stop()
        self.tasks.close()
        self._worker_thread.close()

    def _ready(self) -> bool:
        self.attempt(RUNNING)
        if self.document.image is None:
            self.say(tr("There is no image to run on: open one first."), True, RUNNING)
            return False
        if needs_start(self.document.mode) and not self.document.starts:
            self.say(self.document.nothing_to_start_from, True, RUNNING)
            return False
        return True

    def _start_if_needed(self) -> None:
        status = self.status
        over = status.phase == "finished" and not status.steered
        if status.phase == "ready" or over or status.stale:
            self._generation = self._next_generation()
            self.live.begin(self._generation, self.document)
            self._progress.forget(MODES[self.document.mode].method)
            self.post(Start(self._generation, self._image_generation, self.document))

    def _next_generation(self) -> int:
        self._numbered += 1
        return self._numbered

    def _follow(self, before: Document, after: Document, complete: bool) -> None:
        self.live.follow(before, after, complete)

    def _turn_erasures(self, erasures: Sequence[Erasure], back: bool) -> None:
        goes_on = self.status.phase == "running"
        self.live.turn(erasures, back)
        self.hold(RunCall(None, Run.turn_erasures, tuple(erasure.number for erasure in erasures), back))
        if goes_on:
            self._progress.phase("running")
            self.post(RunCall(self._generation, Run.go))

    def _end_gesture(self) -> None:
        self.live.end_gesture()

    def _wake(self) -> None:
        if not self._timer.isActive():
            self._frames.begin()
            self._timer.start()

    def _frame(self) -> None:
        self._frames.stepped()
        with self.gathering():
            self.tasks.look()
            self._progress.look()
        if self.scene.snapshot is not None:
            self.live.use(self.scene.snapshot.timeline.began)
        if self.idle:
            self._timer.stop()
