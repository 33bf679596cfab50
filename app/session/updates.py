"""Snapshots and reports of the worker: taken once in each display frame, checked, and passed on to the views."""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import Any

from app.model.export import summary_text
from app.model.state.situation import Phase, RunStatus
from app.model.text.language import tr
from app.session.exchange.messages import (
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
from app.session.scene import NO_CONTOURS, ReviewedContours
from app.session.signals import CONTOURS, EDITING, EXPORTING, RUNNING, SessionSignals
from app.session.worker.commands import RunsRestored
from app.session.worker.requests import Compared, Probed, Shaded
from app.session.worker.worker_thread import WorkerThread

_COMPILING = tr("Preparing for the first run on this computer: {percent} %")

_FIGURES_EVERY = 0.1
"""Time between two updates of the numbers in the window [s]."""


class Progress:
    """State of the run as the window knows it."""

    def __init__(self, session: SessionSignals, worker_thread: WorkerThread) -> None:
        self._session = session
        self._worker_thread = worker_thread
        self._busy: dict[str, str] = {}
        self._shown_at = 0.0
        self._known = RunStatus()
        session.listen(Finished, lambda finished: finished.then())
        session.listen(Probed, self._take_probed)
        session.listen(Compared, self._take_compared)
        session.listen(Shaded, lambda shaded: self._show(shaded=shaded))

    @property
    def status(self) -> RunStatus:
        """State of the run."""
        return replace(self._known, busy=next(iter(self._busy.values()), ""))

    def busy(self, what: str, text: str) -> None:
        """Show `text` while something is being prepared."""
        self._busy = {what: text} | {key: value for key, value in self._busy.items() if key != what}
        self._session.show_status()

    def phase(self, phase: Phase) -> None:
        """The user has started or stopped the run."""
        self._known = replace(self._known, phase=phase)
        self._session.show_status()

    def forget(self, method: str = "cpm") -> None:
        """Clear what is shown of the previous run; `method` is the name of the next one's method."""
        self._known = RunStatus(phase="ready", method=method)
        self._session.trouble("", CONTOURS)
        self._show(snapshot=None, reconstruction=None, contours=NO_CONTOURS, probed=None, compared=None)
        self._session.show_status()

    def look(self) -> None:
        """Take what has arrived; drop what belongs to another run or image."""
        for report in self._worker_thread.reports():
            self._take_report(report)
        snapshot = self._worker_thread.snapshots.take()
        if snapshot is not None and snapshot.generation == self._session.generation:
            self._take_snapshot(snapshot)
        contours = self._worker_thread.reconstructor.results.take()
        if contours is not None and contours.generation == self._session.generation:
            self._take_contours(contours)
        overlays = self._worker_thread.overlays.take()
        if overlays is not None and overlays.generation == self._session.image_generation:
            self._session.trouble(overlays.trouble, "overlays")
            self._show(overlays=overlays.arrays)

    def _take_contours(self, found: Reconstruction | ReconstructionFailed) -> None:
        if isinstance(found, ReconstructionFailed):
            trouble = found.sentence
            if self._session.scene.contours.items:
                last = tr("{trouble} The contours that are shown are those of an earlier step.")
                trouble = last.format(trouble=trouble)
            self._session.trouble(trouble, CONTOURS)
            return
        self._session.trouble("", CONTOURS)
        self._known = replace(self._known, found=found.result)
        reviewed = ReviewedContours.of(found.tracked, self._session.scene.document.marks)
        self._show(reconstruction=found, contours=reviewed)
        self._session.show_status()

    def _show(self, **parts: Any) -> None:
        """Replace parts of the scene."""
        self._session.show(replace(self._session.scene, **parts))

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
        if self._known.phase != "running" or before != "running" or now - self._shown_at >= _FIGURES_EVERY:
            self._shown_at = now
            self._session.show_status()

    def _take_report(self, report: Report) -> None:
        match report:
            case Opened():
                self._busy.pop("seeding", None)
                self._busy.pop("restoring", None)
            case RunsRestored(generation, _, shown):
                self._busy.pop("restoring", None)
                if shown and generation == self._session.generation:
                    # the state that is shown may have been taken before this report
                    self._known = replace(self._known, phase="finished" if self._known.stop_reason else "paused")
            case RunFailed(generation, sentence):
                self._busy.pop("restoring", None)
                if generation == self._session.generation:
                    self._known = replace(self._known, phase="paused" if self._known.count else "ready")
                    self._session.say(sentence, True, RUNNING)
            case WentOn(generation):
                if generation == self._session.generation:
                    self._known = replace(self._known, phase="running")
            case SeedsFound(generation, image_seeds, sentence):
                self._busy.pop("seeding", None)
                if sentence:
                    self._session.say(sentence, True, EDITING)
                if generation == self._session.image_generation:
                    self._show(image_seeds=image_seeds)
            case Exported(path, counts):
                written = tr("Written: {path}").format(path=path)
                self._session.say(written if counts is None else f"{written} ({summary_text(counts)})", topic=EXPORTING)
            case CommandFailed(sentence, topic):
                self._session.say(sentence, True, topic)
            case Compiling(percent):
                if "preparing" in self._busy:
                    self._busy["preparing"] = _COMPILING.format(percent=percent)
            case WarmedUp():
                self._busy.pop("preparing", None)
        self._session.pass_on(report)
        self._session.show_status()

    def _take_probed(self, probed: Probed) -> None:
        self._session.trouble(probed.trouble, "forces")
        self._show(probed=probed)

    def _take_compared(self, compared: Compared) -> None:
        if compared.generation == self._session.generation:
            self._show(compared=compared)
